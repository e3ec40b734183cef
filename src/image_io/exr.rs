//! OpenEXR files, as far as they are written: scan lines of single precision without compression.
//!
//! The format is described in "OpenEXR File Layout", <https://openexr.com/en/latest/OpenEXRFileLayout.html>.

/// The first bytes of every file, and the second version of the format, without any of the flags for tiles, long names,
/// deep data and several parts.
pub(super) const START: [u8; 8] = [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];

/// The pixel type of single precision.
pub(super) const FLOAT: i32 = 2;

/// Where the numbers of a file lie in the whole picture.
#[derive(Clone, Copy)]
pub(super) struct ChunkPlace {
    /// Width and height of the whole in pixels.
    pub whole: [u16; 2],
    /// Column and row of the first number, from the top left.
    pub at: [u16; 2],
}

/// What precedes the rows in a file of this width and height in pixels: the attributes, and where each row lies. The
/// channels have to be in alphabetical order.
pub(super) fn header([width, height]: [u16; 2], place: ChunkPlace, channels: &[&str]) -> Vec<u8> {
    let mut bytes = START.to_vec();
    attribute(&mut bytes, "channels", "chlist", &channel_list(channels));
    attribute(&mut bytes, "compression", "compression", &[0]);
    attribute(&mut bytes, "dataWindow", "box2i", &window(place.at, [width, height]));
    attribute(&mut bytes, "displayWindow", "box2i", &window([0, 0], place.whole));
    // From the top.
    attribute(&mut bytes, "lineOrder", "lineOrder", &[0]);
    attribute(&mut bytes, "pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute(&mut bytes, "screenWindowCenter", "v2f", &[0; 8]);
    attribute(&mut bytes, "screenWindowWidth", "float", &1f32.to_le_bytes());
    bytes.push(0);
    let row =
        row_start(0, usize::from(width) * channels.len()).len() + usize::from(width) * channels.len() * 4;
    let first = bytes.len() + usize::from(height) * size_of::<u64>();
    let places = (0..usize::from(height)).map(|y| (first + y * row) as u64);
    bytes.extend(places.flat_map(u64::to_le_bytes));
    bytes
}

/// What precedes the numbers of a row, which is counted from the top of the whole: its index and its length in bytes.
/// The numbers are those of the first channel, then those of the next.
pub(super) fn row_start(row: usize, numbers: usize) -> [u8; 8] {
    let mut start = [0; 8];
    start[..4].copy_from_slice(&(row as i32).to_le_bytes());
    start[4..].copy_from_slice(&((numbers * size_of::<f32>()) as i32).to_le_bytes());
    start
}

/// The first and the last column and row of a rectangle.
fn window(at: [u16; 2], size: [u16; 2]) -> Vec<u8> {
    let [[x, y], [width, height]] = [at, size].map(|pair| pair.map(i32::from));
    [x, y, x + width - 1, y + height - 1].map(i32::to_le_bytes).concat()
}

fn channel_list(channels: &[&str]) -> Vec<u8> {
    let mut list = Vec::new();
    for name in channels {
        list.extend_from_slice(name.as_bytes());
        list.push(0);
        // The type, four bytes without a meaning here, and a sample for each pixel along both axes.
        [FLOAT, 0, 1, 1].iter().for_each(|number| list.extend_from_slice(&number.to_le_bytes()));
    }
    list.push(0);
    list
}

fn attribute(bytes: &mut Vec<u8>, name: &str, kind: &str, value: &[u8]) {
    for text in [name, kind] {
        bytes.extend_from_slice(text.as_bytes());
        bytes.push(0);
    }
    bytes.extend_from_slice(&(value.len() as i32).to_le_bytes());
    bytes.extend_from_slice(value);
}
