//! What a law of pairs says in one meeting: the message between two nodes of the scene, and the invariants it was made of.

/// The message of a meeting: the acceleration `N n + T v_t/|v_t|` of the particle that is met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Message {
    /// Who meets whom: a place in [`crate::graph::EDGE_KINDS`].
    pub kind: usize,
    /// Distance r of the centres, or of the centre from the surface, negative inside \[m\].
    pub distance: f64,
    /// Separating speed v·n \[m/s\].
    pub separating: f64,
    /// Sliding speed |v_t| \[m/s\].
    pub sliding: f64,
    /// N, positive where it pushes apart \[m/s²\].
    pub normal: f64,
    /// T, negative where it holds back \[m/s²\].
    pub tangential: f64,
}
