//! Bonds: particles that are near each other at the start hold on to each other, yield, and break.
use super::compliant::{not_negative, positive, swing};
use super::history::{History, Remember};
use super::{Law, View, ViewGrad};
use crate::graph::CellList;
use crate::state::{Particles, ParticlesGrad};
use anyhow::ensure;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Config of [`Bonds`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BondsSpec {
    /// Distance of two particles of one body below which they are bonded when a rollout starts \[m\].
    #[schemars(range(min = 1e-6))]
    pub reach: f64,
    /// Stiffness k over a particle's mass \[s^-2\].
    #[schemars(range(min = 0.0))]
    pub stiffness: f64,
    /// Damping c of the separating speed over a particle's mass \[1/s\].
    #[schemars(range(min = 0.0))]
    pub damping: f64,
    /// Elastic strain ε_y beyond which a bond flows, below 1; left out, it never does \[1\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yield_strain: Option<f64>,
    /// Strain of the bond's first length beyond which it breaks for good; left out, it never does \[1\].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub breaking_strain: Option<f64>,
}

impl BondsSpec {
    pub(crate) fn build(self) -> anyhow::Result<Bonds> {
        positive("bonds", "reach", self.reach)?;
        not_negative("bonds", "stiffness", self.stiffness)?;
        not_negative("bonds", "damping", self.damping)?;
        if let Some(strain) = self.yield_strain {
            positive("bonds", "yield_strain", strain)?;
            ensure!(strain < 1.0, "yield_strain of the law \"bonds\" must be below 1, got {strain}");
        }
        self.breaking_strain.map_or(Ok(()), |strain| positive("bonds", "breaking_strain", strain))?;
        Ok(Bonds(self))
    }
}

/// `a = −(k (r − L) + c v_n) n` on one particle of a bond and the opposite on the other, L its rest length, r its length.
///
/// L starts as the length at the start of the rollout, L₀. Where the elastic strain `(r − L)/L` passes ±ε_y, L flows until it is
/// ±ε_y again, `L ← r/(1 ± ε_y)` (perfect plasticity by return mapping, Simo & Hughes 1998, box 1.4). Where `(r − L₀)/L₀` passes the
/// breaking strain, the bond is forgotten; no derivative passes through whether it is. Momentum, linear and angular, is kept to
/// rounding. Stable for substeps `h ≤ 0.1 π √(1/(2 k m))` and
/// `h ≤ 0.1 π/(2 c m)`, m = 12 the bonds of one particle in a close packing.
pub struct Bonds(BondsSpec);

/// Bonds of one particle in a close packing.
const NEIGHBOURS: f64 = 12.0;

/// The two rest lengths of a bond: now, and at the start.
const LENGTHS: usize = 2;

/// What a bond's rest length becomes, with its derivatives by r, L and ε_y.
struct Flow {
    length: f64,
    by_distance: f64,
    by_length: f64,
    by_strain: f64,
}

/// Two bonded particles: their distance, the normal from j to i, and the velocity of i relative to j.
struct Stretch {
    ends: [usize; 2],
    distance: f64,
    normal: DVec3,
    velocity: DVec3,
}

impl Stretch {
    fn of([i, j]: [u32; 2], particles: &Particles) -> Self {
        let (i, j) = (i as usize, j as usize);
        let offset = particles.positions[i] - particles.positions[j];
        let distance = offset.length();
        // Two particles in one place have no direction to push in.
        let normal = if distance > 0.0 { offset / distance } else { DVec3::ZERO };
        Self { ends: [i, j], distance, normal, velocity: particles.velocities[i] - particles.velocities[j] }
    }

    /// Adds a derivative by the distance to the positions.
    fn pull(&self, by_distance: f64, grad: &mut ParticlesGrad) {
        let [i, j] = self.ends;
        grad.positions[i] += by_distance * self.normal;
        grad.positions[j] -= by_distance * self.normal;
    }
}

impl Bonds {
    fn flow(&self, distance: f64, length: f64) -> Flow {
        let returned = |limit: f64, sign: f64| Flow {
            length: distance / limit,
            by_distance: limit.recip(),
            by_length: 0.0,
            by_strain: -sign * distance / (limit * limit),
        };
        match self.0.yield_strain {
            Some(strain) if distance > length * (1.0 + strain) => returned(1.0 + strain, 1.0),
            Some(strain) if distance < length * (1.0 - strain) => returned(1.0 - strain, -1.0),
            _ => Flow { length, by_distance: 0.0, by_length: 1.0, by_strain: 0.0 },
        }
    }

    /// Calls `visit(place, bond, L, L₀)` with every bond that the view's history holds.
    fn each(view: &View<'_>, mut visit: impl FnMut(usize, &Stretch, f64, f64)) {
        for (place, pair) in view.history.pairs().iter().enumerate() {
            let [length, first] = view.history.row::<LENGTHS>(place);
            visit(place, &Stretch::of(*pair, view.particles), length, first);
        }
    }

    /// The same with the bonds that hold, and what their rest lengths become.
    fn holding(&self, view: &View<'_>, mut visit: impl FnMut(usize, &Stretch, Flow, f64)) {
        let most = 1.0 + self.0.breaking_strain.unwrap_or(f64::INFINITY);
        Self::each(view, |place, bond, length, first| {
            // What is not a number is no broken bond: it must be seen.
            let breaks = bond.distance > first * most;
            if !breaks {
                visit(place, bond, self.flow(bond.distance, length), first);
            }
        });
    }
}

impl Law for Bonds {
    fn remembers(&self) -> Option<&dyn Remember> {
        Some(self)
    }

    fn stable(&self) -> f64 {
        let damped = (2.0 * NEIGHBOURS * self.0.damping).recip();
        swing(2.0 * self.0.stiffness * NEIGHBOURS).min(0.1 * std::f64::consts::PI * damped)
    }

    fn accelerate(&self, view: &View<'_>, out: &mut [DVec3]) {
        Self::each(view, |_, bond, length, _| {
            let [i, j] = bond.ends;
            let pull = self.0.stiffness * (bond.distance - length) + self.0.damping * bond.velocity.dot(bond.normal);
            out[i] -= pull * bond.normal;
            out[j] += pull * bond.normal;
        });
    }

    fn accelerate_vjp(&self, view: &View<'_>, out: &[DVec3], grad: &mut ViewGrad<'_>) {
        let BondsSpec { stiffness, damping, .. } = self.0;
        Self::each(view, |place, bond, length, _| {
            let ([i, j], n) = (bond.ends, bond.normal);
            let at = out[i] - out[j];
            let pull = stiffness * (bond.distance - length) + damping * bond.velocity.dot(n);
            let by_pull = -at.dot(n);
            let by_normal = damping * by_pull * bond.velocity - pull * at;
            if bond.distance > 0.0 {
                let turning = (by_normal - n * n.dot(by_normal)) / bond.distance;
                grad.particles.positions[i] += turning;
                grad.particles.positions[j] -= turning;
            }
            bond.pull(stiffness * by_pull, &mut grad.particles);
            grad.particles.velocities[i] += damping * by_pull * n;
            grad.particles.velocities[j] -= damping * by_pull * n;
            grad.history[LENGTHS * place] -= stiffness * by_pull;
        });
    }

    fn constants(&self) -> Vec<&str> {
        let flows = self.0.yield_strain.map(|_| "yield_strain");
        ["stiffness", "damping"].into_iter().chain(flows).collect()
    }

    fn constants_vjp(&self, view: &View<'_>, out: &[DVec3], constants: &mut [f64]) {
        Self::each(view, |_, bond, length, _| {
            let by_pull = -(out[bond.ends[0]] - out[bond.ends[1]]).dot(bond.normal);
            constants[0] += (bond.distance - length) * by_pull;
            constants[1] += bond.velocity.dot(bond.normal) * by_pull;
        });
    }
}

impl Remember for Bonds {
    fn begin(&self, particles: &Particles, body: &[u32]) -> History {
        let positions = &particles.positions[..];
        let near = CellList::new(positions, self.0.reach).neighbours(positions, self.0.reach);
        let mut history = History::default();
        for (i, j) in near.pairs().filter(|&(i, j)| i < j && body[i] == body[j]) {
            let distance = positions[i].distance(positions[j]);
            if distance > 0.0 {
                history.push([i as u32, j as u32], &[distance; LENGTHS]);
            }
        }
        history
    }

    fn begin_vjp(&self, particles: &Particles, history: &History, at: &[f64], grad: &mut ParticlesGrad) {
        for (pair, by) in history.pairs().iter().zip(at.chunks_exact(LENGTHS)) {
            Stretch::of(*pair, particles).pull(by.iter().sum(), grad);
        }
    }

    fn advance(&self, view: &View<'_>, _: f64) -> History {
        let mut next = History::default();
        self.holding(view, |place, _, flow, first| next.push(view.history.pairs()[place], &[flow.length, first]));
        next
    }

    fn advance_vjp(&self, view: &View<'_>, _: f64, at: &[f64], grad: &mut ViewGrad<'_>) {
        let mut rows = at.chunks_exact(LENGTHS);
        self.holding(view, |place, bond, flow, _| {
            let Some([by_length, by_first]) = rows.next() else { return };
            bond.pull(flow.by_distance * by_length, &mut grad.particles);
            grad.history[LENGTHS * place] += flow.by_length * by_length;
            grad.history[LENGTHS * place + 1] += by_first;
        });
    }

    fn advance_constants_vjp(&self, view: &View<'_>, _: f64, at: &[f64], constants: &mut [f64]) {
        let Some(by_strain) = constants.get_mut(2) else { return };
        let mut rows = at.chunks_exact(LENGTHS);
        self.holding(view, |_, _, flow, _| *by_strain += flow.by_strain * rows.next().map_or(0.0, |by| by[0]));
    }
}
