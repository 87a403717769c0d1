//! One control interval: particles to grid, grid, and back, substep by substep.
use super::contact::Contacts;
use super::continuum::Continuum;
use super::grid::{Affine, Grid, Span, extend, place, split};
use super::real::{Matrix, Real, Vector};
use super::spectrum::{LANES, Spectra, Spectrum};
use super::{MpmModel, MpmState, Points};
use crate::model::placed::Placed;
use crate::state::{Control, Twist};
use glam::DVec3;

/// Where the grid lay, and what its nodes were: number, velocity and mass before contacts, velocity after.
pub(super) struct Met<R: Real> {
    pub(super) spans: Vec<Span>,
    /// End of each substep's nodes in `nodes`.
    pub(super) ends: Vec<usize>,
    pub(super) nodes: Vec<Node<R>>,
}

/// A node that some particle reaches.
#[derive(Clone, Copy)]
pub(super) struct Node<R: Real> {
    pub(super) number: u32,
    pub(super) mass: R,
    pub(super) before: R::Vector,
    pub(super) after: R::Vector,
}

/// What the adjoint of an interval needs of it, substep after substep in long lists.
pub(super) struct Tape<R: Real> {
    pub(super) points: Points<R>,
    pub(super) spectra: Vec<Spectrum<R>>,
    pub(super) met: Met<R>,
}

impl<R: Real> Default for Tape<R> {
    fn default() -> Self {
        let met = Met { spans: Vec::new(), ends: Vec::new(), nodes: Vec::new() };
        Self { points: Points::default(), spectra: Vec::new(), met }
    }
}

impl<R: Real> Tape<R> {
    /// Empty again, its memory kept.
    pub(super) fn clear(&mut self) {
        self.points.clear();
        self.spectra.clear();
        self.met.spans.clear();
        self.met.ends.clear();
        self.met.nodes.clear();
    }
}

/// What stays the same over the substeps of one interval.
pub(super) struct Interval<'a, R: Real> {
    pub(super) model: &'a MpmModel,
    pub(super) continuum: &'a Continuum<R>,
    pub(super) state: &'a MpmState,
    pub(super) control: &'a Control,
    pub(super) substeps: usize,
    /// Duration of a substep h \[s\].
    pub(super) h: R,
    /// 4/Δ², the inverse second moment of the weights \[m⁻²\].
    pub(super) sharp: R,
    /// Velocity that gravity gives in a substep \[m/s\].
    pub(super) fall: R::Vector,
    twists: Vec<Twist>,
}

impl<'a, R: Real> Interval<'a, R> {
    pub(super) fn new(
        model: &'a MpmModel,
        continuum: &'a Continuum<R>,
        state: &'a MpmState,
        control: &'a Control,
    ) -> Self {
        let path = state.poses.iter().zip(&control.poses);
        let substeps = model.substeps(state.interval);
        let h = state.interval / substeps as f64;
        Self {
            model,
            continuum,
            state,
            control,
            substeps,
            h: R::of(h),
            sharp: R::of(4.0 / (model.cell * model.cell)),
            fall: R::Vector::of(-h * model.gravity * DVec3::Z),
            twists: path.map(|(from, to)| from.twist_to(to, state.interval)).collect(),
        }
    }

    /// How far the tool has come in substep `k`, of the way from its start to its end.
    pub(super) fn fraction(&self, k: usize) -> f64 {
        (k + 1) as f64 / self.substeps as f64
    }

    /// What nodes may meet in substep `k`.
    pub(super) fn contacts(&self, k: usize) -> Contacts<'a> {
        let (state, model) = (self.state, self.model);
        let reach = Contacts::REACH * model.softness;
        let path = state.poses.iter().zip(&self.control.poses).map(|(from, to)| from.toward(to, self.fraction(k)));
        let parts = state.tool.parts.iter().zip(path).zip(&self.twists);
        Contacts {
            parts: parts.map(|((part, pose), twist)| Placed::new(&part.solid, &pose, twist, reach)).collect(),
            tool: &model.tool,
            softness: model.softness,
            walls: &state.walls,
            table: &model.table,
        }
    }

    /// The trial elastic tensor `M b Mᵀ` with `M = I + h C`, and M.
    #[inline]
    pub(super) fn trial(&self, affine: R::Matrix, strain: R::Matrix) -> (R::Matrix, R::Matrix) {
        let growth = R::Matrix::IDENTITY + affine * self.h;
        (growth * strain * growth.transpose(), growth)
    }

    /// What a particle tells the nodes of its momentum: `a = (v, 1)`, `B = C − h (4/Δ²) τ/ρ`.
    #[inline]
    pub(super) fn momentum(&self, velocity: R::Vector, affine: R::Matrix, stress: R::Matrix) -> Affine<R> {
        let viscous = (affine + affine.transpose()) * self.continuum.viscosity;
        let spread = affine - (stress + viscous) * (self.h * self.sharp);
        Affine { value: extend(velocity, R::ONE), slopes: spread.columns().map(|c| extend(c, R::ZERO)) }
    }

    /// The points at the end; what happened in every substep goes onto the tape, where there is one.
    pub(super) fn advance(&self, mut tape: Option<&mut Tape<R>>) -> Points<R> {
        let mut points = Points::of(&self.state.points);
        let mut grid = Grid::new(self.model.cell);
        let mut spectra = Spectra::new();
        for k in 0..self.substeps {
            if !grid.cover(&points.positions) {
                // Blown apart: what is not a number is counted as such, and costs infinity.
                points.positions.fill(DVec3::NAN);
                points.velocities.fill(R::Vector::of(DVec3::NAN));
                return points;
            }
            if let Some(tape) = &mut tape {
                tape.points.extend(&points);
            }
            self.particles_to_grid(&mut points, &mut grid, &mut spectra, tape.as_deref_mut());
            self.meet(k, &mut grid, tape.as_deref_mut());
            self.grid_to_particles(&mut points, &grid);
        }
        points
    }

    /// Strains the material and sums masses and momenta over the grid.
    fn particles_to_grid(
        &self,
        points: &mut Points<R>,
        grid: &mut Grid<R>,
        spectra: &mut Spectra<R>,
        mut tape: Option<&mut Tape<R>>,
    ) {
        let count = points.positions.len();
        for first in (0..count).step_by(LANES) {
            let lanes = LANES.min(count - first);
            for lane in 0..lanes {
                let i = first + lane;
                points.strain[i] = self.trial(points.affine[i], points.strain[i]).0;
                spectra.set(lane, points.strain[i]);
            }
            spectra.decompose();
            for lane in 0..lanes {
                let i = first + lane;
                let spectrum = spectra.get(lane);
                let (kept, stress) = self.continuum.material.flow(points.strain[i], &spectrum);
                points.strain[i] = kept;
                let momentum = self.momentum(points.velocities[i], points.affine[i], stress);
                let stencil = grid.stencil(points.positions[i]);
                grid.scatter(&stencil, &momentum);
                if let Some(tape) = &mut tape {
                    tape.spectra.push(spectrum);
                }
            }
        }
    }

    /// Turns momenta into velocities, and lets gravity and contacts act on them.
    fn meet(&self, k: usize, grid: &mut Grid<R>, mut tape: Option<&mut Tape<R>>) {
        let contacts = self.contacts(k);
        let (span, cell) = (grid.span(), grid.cell);
        for (number, node) in grid.nodes.iter_mut().enumerate() {
            let (momentum, mass) = split::<R>(*node);
            if mass > R::ZERO {
                let before = momentum / mass + self.fall;
                let after = R::Vector::of(contacts.act(place(&span, cell, number), before.wide()));
                *node = extend(after, R::ZERO);
                if let Some(tape) = &mut tape {
                    tape.met.nodes.push(Node { number: number as u32, mass, before, after });
                }
            }
        }
        if let Some(tape) = tape {
            tape.met.spans.push(span);
            tape.met.ends.push(tape.met.nodes.len());
        }
    }

    /// Gives every particle the velocity of the nodes around it, and moves it.
    fn grid_to_particles(&self, points: &mut Points<R>, grid: &Grid<R>) {
        let Points { positions, velocities, affine, .. } = points;
        for ((x, v), c) in positions.iter_mut().zip(velocities).zip(affine) {
            let Affine { value, slopes } = grid.gather(&grid.stencil(*x));
            *v = split::<R>(value).0;
            *c = R::Matrix::new(slopes.map(|column| split::<R>(column).0 * self.sharp));
            *x += (*v * self.h).wide();
        }
    }
}
