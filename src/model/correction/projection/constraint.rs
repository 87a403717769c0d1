//! What a projection asks of positions: one constraint, and how its data follow from prediction, start and tool.
use crate::model::law::ViewGrad;
use crate::model::law::compliant::ContactGrad;
use crate::model::law::tool::Touch;
use glam::DVec3;

/// One constraint `g(x) ≤ 0`.
pub(super) enum Constraint<'a> {
    /// `n·xᵢ ≥ bound`.
    Front {
        /// i.
        particle: usize,
        /// n.
        normal: DVec3,
        /// Bound \[m\].
        bound: f64,
        /// The touch that n and bound follow from; none of a plane.
        touch: Option<Touch<'a>>,
    },
    /// `n·(xᵢ − xⱼ) ≥ least`, n along the prediction.
    Apart {
        /// i and j.
        pair: [usize; 2],
        /// n.
        normal: DVec3,
        /// Least distance \[m\].
        least: f64,
    },
    /// `|xᵢ − xⱼ| ≤ most`.
    Within {
        /// i and j.
        pair: [usize; 2],
        /// Greatest distance \[m\].
        most: f64,
        /// `∂most/∂(xᵢ − xⱼ)` of the start.
        slope: DVec3,
    },
}

/// What a constraint's part in the derivative is made of.
pub(super) struct Pull {
    /// Multiplier λ \[m\].
    pub(super) multiplier: f64,
    /// Multiplier q of the adjoint's constraint; zero where the constraint is not active.
    pub(super) adjoint: f64,
    /// Adjoint p of the particle, or of the pair, `pᵢ − pⱼ`.
    pub(super) by: DVec3,
    /// Solution x, or `xᵢ − xⱼ` \[m\].
    pub(super) at: DVec3,
}

impl Constraint<'_> {
    /// The particles that it binds; the second is subtracted from the first.
    pub(super) fn particles(&self) -> (usize, Option<usize>) {
        match self {
            Self::Front { particle, .. } => (*particle, None),
            Self::Apart { pair: [i, j], .. } | Self::Within { pair: [i, j], .. } => (*i, Some(*j)),
        }
    }

    /// x or `xᵢ − xⱼ` of what it binds.
    pub(super) fn of(&self, rows: &[DVec3]) -> DVec3 {
        let (i, j) = self.particles();
        rows[i] - j.map_or(DVec3::ZERO, |j| rows[j])
    }

    /// `∇g` with respect to [`Constraint::of`], where that is `at`.
    pub(super) fn slope(&self, at: DVec3) -> DVec3 {
        match self {
            Self::Front { normal, .. } | Self::Apart { normal, .. } => -*normal,
            Self::Within { .. } => at.normalize_or_zero(),
        }
    }

    /// Adds `−∂φ/∂θ` of `φ = λ p·∇g + q g` to the prediction's part in `grad`, to the tool's, and to the start's.
    pub(super) fn pull(&self, pull: &Pull, predicted: &[DVec3], grad: &mut ViewGrad<'_>, start: &mut [DVec3]) {
        let Pull { multiplier, adjoint, by, at } = pull;
        match self {
            Self::Front { touch: None, .. } => {}
            // g = c − d − n·(x − x̂): what x̂ does to the bound by itself, and through d, cancels.
            Self::Front { touch: Some(touch), particle, normal, .. } => {
                let turn = *multiplier * *by + *adjoint * (*at - predicted[*particle]);
                touch.pull(&ContactGrad { overlap: -adjoint, normal: turn, velocity: DVec3::ZERO }, grad);
                grad.particles.positions[*particle] -= *adjoint * *normal;
            }
            Self::Apart { pair: [i, j], normal, .. } => {
                let turn = *multiplier * *by + *adjoint * *at;
                let across = (turn - normal.dot(turn) * *normal) / (predicted[*i] - predicted[*j]).length();
                grad.particles.positions[*i] += across;
                grad.particles.positions[*j] -= across;
            }
            Self::Within { pair: [i, j], slope, .. } => {
                start[*i] += *adjoint * *slope;
                start[*j] -= *adjoint * *slope;
            }
        }
    }
}
