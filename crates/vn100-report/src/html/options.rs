//! What a page says besides its results.

use vn100_analysis::RemedyWords;

/// The content of a page other than the results.
#[derive(Debug, Clone, Copy)]
pub struct PageOptions<'a> {
    /// Two-sided level of the intervals of a comparison, 0 < p < 1.
    pub confidence: f64,
    /// The command line, as a user would repeat it.
    pub asked: &'a str,
    /// The words of a face for remedies.
    pub words: RemedyWords,
    /// The program that writes the page.
    pub program: Program<'a>,
    /// The time over which a filter integrates, in seconds.
    pub span_s: f64,
}

/// A program, by name and commit.
#[derive(Debug, Clone, Copy)]
pub struct Program<'a> {
    /// Name and version, such as `vn100 1.0.0`.
    pub name: &'a str,
    /// The commit it was built from; `None` if that is not known.
    pub commit: Option<&'a str>,
}
