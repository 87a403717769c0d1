//! What choosers may learn from before there is a decision to take.
use super::Chooser;
use crate::config::Fingerprint;
use crate::tool::Tool;
use crate::train::Split;
use crate::watch::Watch;
use indexmap::IndexMap;
use std::path::Path;

/// Everything that is known before the first attempt, and where to keep what is learned of it.
#[derive(Clone, Copy)]
pub struct Lesson<'a> {
    /// Episodes to learn from and to be judged by.
    pub data: &'a Split,
    /// Fingerprint of those episodes.
    pub dataset: &'a Fingerprint,
    /// The tools that there will be.
    pub tools: &'a IndexMap<String, Box<dyn Tool>>,
    /// Root of artifacts.
    pub root: &'a Path,
    /// Shows progress, and asks to stop.
    pub watch: &'a Watch,
}

/// Makes a chooser of a lesson; who has nothing to learn makes itself.
pub trait ChooserMaker: Send + Sync {
    /// The chooser.
    ///
    /// # Errors
    /// When the lesson does not suit, a fit fails, a file cannot be written, or a stop was asked for.
    fn make(&self, lesson: &Lesson<'_>) -> anyhow::Result<Box<dyn Chooser>>;
}

impl<C: Chooser + Clone + 'static> ChooserMaker for C {
    fn make(&self, _: &Lesson<'_>) -> anyhow::Result<Box<dyn Chooser>> {
        Ok(Box::new(self.clone()))
    }
}
