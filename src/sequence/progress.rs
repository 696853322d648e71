//! How a run tells of its progress, whoever shows it.

/// Hears of stages and of the work done in each.
pub trait Progress: Sync {
    /// A stage begins; `total` is its work where that is known.
    fn start(&self, stage: &str, total: Option<u64>);
    /// So much more is done.
    fn advance(&self, n: u64);
    /// What the stage has come to, in a few words.
    fn say(&self, text: &str);
    /// The stage is over.
    fn finish(&self);
}

/// Shows nothing.
pub struct Silent;

impl Progress for Silent {
    fn start(&self, _: &str, _: Option<u64>) {}
    fn advance(&self, _: u64) {}
    fn say(&self, _: &str) {}
    fn finish(&self) {}
}
