//! The number of rows of a strip, and the memory that it takes.

use super::*;
use crate::sampling::filter::Filter;

fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(work)
}

#[test]
fn a_strip_has_as_many_rows_as_the_memory_holds() {
    let rows = |layers: &[Layer], filter, end, first| {
        let request = Request { layers: layers.to_vec(), filter, ..Request::new([1 << 16, 1 << 12]) };
        on_one_thread(|| Strip::below(&request, end, first).rows)
    };
    let (one, wide) = (Filter::PIXEL, Filter::Box { radius: 7.5 });
    // Memory for 32 rows of 2^16 colours of 24 bytes.
    assert_eq!(rows(&[Layer::Color], one, 4096, 0), 4064..4096);
    assert_eq!(rows(&[Layer::Color], one, 4096, 4080), 4080..4096);
    assert_eq!(rows(&[Layer::Color], one, 20, 0), 0..20);
    assert_eq!(rows(&[Layer::Color, Layer::Normals, Layer::Color], one, 4096, 0), 4086..4096);
    assert_eq!(rows(&[Layer::Samples { zoom: 2 }], one, 4096, 0), 4088..4096);
    assert_eq!(rows(&[Layer::Samples { zoom: 9 }], one, 4096, 0), 4095..4096);
    assert_eq!(rows(&[Layer::Filter { zoom: 2 }], one, 4096, 0), 0..4096);
    // Seven rows beside a strip are traced for it, so it has at least eight times as many rows.
    assert_eq!(rows(&[Layer::Color], wide, 4096, 0), 4040..4096);
    assert_eq!(rows(&[Layer::Normals], wide, 4096, 0), 4064..4096);
}

#[test]
fn so_many_rows_are_in_flight_as_the_memory_holds_or_as_keep_the_threads_busy() {
    let rows = |filter, width| {
        let request = Request { filter, ..Request::new([width, 1 << 12]) };
        on_one_thread(|| Strip::below(&request, 1, 0).rows_in_flight())
    };
    let widths = [1 << 10, 1 << 16, 1 << 30];
    assert_eq!(widths.map(|width| rows(Filter::PIXEL, width)), [32, 16, 1]);
    // Each of the three rows of sums takes as many bytes per pixel as the row itself.
    assert_eq!(rows(Filter::Box { radius: 1.5 }, 1 << 16), 4);
}
