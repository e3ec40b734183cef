//! Measurements for the report: one file for each case, in the folder that `ACCURACY_DIR` names.

/// The evidence for a row of the report.
#[derive(Clone, Copy)]
pub enum Basis {
    /// A machine-checked proof of the error bounds, which the inputs test.
    Proved,
    /// Inputs that were drawn or searched for, from a seed.
    Sampled,
}

impl Basis {
    fn word(self) -> &'static str {
        match self {
            Self::Proved => "proved",
            Self::Sampled => "sampled",
        }
    }
}

/// The measurements of a case.
pub struct Record<'a> {
    /// Its number in the table of hard cases, 1 to 66.
    pub case: u32,
    pub basis: Basis,
    pub name: &'a str,
    /// The inputs, for example "1000000 rays".
    pub inputs: String,
    /// The measure, for example "leaks".
    pub measure: &'a str,
    /// The textbook's method, and its result on the same inputs.
    pub textbook: String,
    /// The result of this program.
    pub ours: String,
    pub target: &'a str,
}

impl Record<'_> {
    /// Prints the record, and writes it to a file if `ACCURACY_DIR` is set. Tabs separate the fields.
    pub fn write(&self) {
        let basis = self.basis.word();
        let fields = [basis, self.name, &self.inputs, self.measure, &self.textbook, &self.ours, self.target];
        let line = format!("{}\t{}\n", self.case, fields.map(|f| f.replace(['\t', '\n'], " ")).join("\t"));
        print!("{line}");
        if let Some(folder) = std::env::var_os("ACCURACY_DIR") {
            let file = std::path::Path::new(&folder).join(format!("{:02}.tsv", self.case));
            std::fs::write(&file, line).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        }
    }
}
