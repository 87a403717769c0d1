//! A block of meetings: invariants into the formulas, accelerations and gradients out of them.
use super::programs::{Motion, OUTPUTS, Programs, REST};
use crate::model::formula::{BLOCK, Program, Workspace};
use crate::model::law::compliant::ContactGrad;
use glam::DVec3;

/// A number for each meeting of a block.
pub(super) type Row = [f64; BLOCK];

/// A vector for each meeting of a block, by component.
#[derive(Clone)]
pub(super) struct Rows(pub(super) [Row; 3]);

impl Rows {
    fn zero() -> Self {
        Self([[0.0; BLOCK]; 3])
    }

    #[inline]
    pub(super) fn set(&mut self, k: usize, v: DVec3) {
        let Self([x, y, z]) = self;
        (x[k], y[k], z[k]) = (v.x, v.y, v.z);
    }

    #[inline]
    pub(super) fn get(&self, k: usize) -> DVec3 {
        let Self([x, y, z]) = self;
        DVec3::new(x[k], y[k], z[k])
    }
}

/// Meetings that wait for the formulas, and what these say; rows beyond the last meeting hold leftovers.
pub(super) struct Meetings<'a> {
    programs: &'a Programs,
    program: &'a Program,
    workspace: Workspace,
    /// Distance r \[m\].
    pub(super) distance: Row,
    /// Unit normal toward the particle.
    pub(super) normal: Rows,
    /// Velocity of the particle relative to what it meets \[m/s\]; only where the formulas look at it.
    pub(super) velocity: Rows,
    /// After [`Meetings::accelerate`]: acceleration \[m/s²\]. Before [`Meetings::pull`]: `∂J/∂acceleration`.
    pub(super) acceleration: Rows,
    /// After [`Meetings::pull`]: `∂J/∂distance`, `∂J/∂normal`, `∂J/∂velocity`.
    pub(super) by_distance: Row,
    pub(super) by_normal: Rows,
    pub(super) by_velocity: Rows,
    sliding: Rows,
}

impl<'a> Meetings<'a> {
    /// For [`Meetings::accelerate`].
    pub(super) fn forward(programs: &'a Programs) -> Box<Self> {
        Self::with(programs, programs.forward_program())
    }

    /// For [`Meetings::pull`].
    pub(super) fn adjoint(programs: &'a Programs) -> Box<Self> {
        Self::with(programs, programs.adjoint_program())
    }

    /// For [`Meetings::pull_constants`].
    pub(super) fn constants(programs: &'a Programs) -> Box<Self> {
        Self::with(programs, programs.slopes_program())
    }

    fn with(programs: &'a Programs, program: &'a Program) -> Box<Self> {
        Box::new(Self {
            programs,
            program,
            workspace: program.workspace(),
            distance: [1.0; BLOCK],
            normal: Rows::zero(),
            velocity: Rows::zero(),
            acceleration: Rows::zero(),
            by_distance: [0.0; BLOCK],
            by_normal: Rows::zero(),
            by_velocity: Rows::zero(),
            sliding: Rows::zero(),
        })
    }

    pub(super) fn reach(&self) -> f64 {
        self.programs.reach
    }

    /// Whether the formulas look at velocities.
    pub(super) fn moves(&self) -> bool {
        self.programs.motion > Motion::None
    }

    /// Runs the program on the invariants.
    fn run(&mut self) {
        let Rows([nx, ny, nz]) = &self.normal;
        let Rows([vx, vy, vz]) = &self.velocity;
        let Rows([sx, sy, sz]) = &mut self.sliding;
        self.workspace.input(0).copy_from_slice(&self.distance);
        let overlaps = self.workspace.input(1).iter_mut().zip(&self.distance);
        overlaps.for_each(|(overlap, distance)| *overlap = self.programs.reach - distance);
        if self.programs.motion > Motion::None {
            let separating = self.workspace.input(2);
            for k in 0..BLOCK {
                separating[k] = vx[k] * nx[k] + vy[k] * ny[k] + vz[k] * nz[k];
            }
        }
        if self.programs.motion == Motion::Sliding {
            let separating = *self.workspace.input(2);
            let square = self.workspace.input(3);
            for k in 0..BLOCK {
                sx[k] = vx[k] - separating[k] * nx[k];
                sy[k] = vy[k] - separating[k] * ny[k];
                sz[k] = vz[k] - separating[k] * nz[k];
                square[k] = sx[k] * sx[k] + sy[k] * sy[k] + sz[k] * sz[k] + REST;
            }
        }
        self.program.run(&mut self.workspace);
    }

    /// `a = N n + (T/|v_t|) v_t`.
    pub(super) fn accelerate(&mut self) {
        self.run();
        let push = self.program.output(&self.workspace, 0);
        let drag = self.program.output(&self.workspace, 1);
        for axis in 0..3 {
            let (out, n, s) = (&mut self.acceleration.0[axis], &self.normal.0[axis], &self.sliding.0[axis]);
            match self.programs.motion {
                Motion::Sliding => (0..BLOCK).for_each(|k| out[k] = push[k] * n[k] + drag[k] * s[k]),
                _ => (0..BLOCK).for_each(|k| out[k] = push[k] * n[k]),
            }
        }
    }

    /// With ā = `∂J/∂a`, N̄ = ā·n, ḡ = ā·v_t and `f̄_x = N̄ ∂N/∂x + ḡ ∂(T/|v_t|)/∂x`:
    /// `v̄_t = (T/|v_t|) ā + 2 f̄_{|v_t|²} v_t`, `w = f̄_{v·n} − v̄_t·n`, `v̄ = v̄_t + w n`,
    /// `n̄ = N ā − (v·n) v̄_t + w v`, `r̄ = f̄_r`.
    pub(super) fn pull(&mut self) {
        self.run();
        let output = |place: usize| self.program.output(&self.workspace, place);
        let [push, drag] = [output(0), output(1)];
        let [[push_r, drag_r], [push_v, drag_v], [push_s, drag_s]] =
            [1, 2, 3].map(|k| [output(OUTPUTS * k), output(OUTPUTS * k + 1)]);
        let (Rows([nx, ny, nz]), Rows([sx, sy, sz])) = (&self.normal, &self.sliding);
        let (Rows([vx, vy, vz]), Rows([ax, ay, az])) = (&self.velocity, &self.acceleration);
        let (Rows([bnx, bny, bnz]), Rows([bvx, bvy, bvz])) = (&mut self.by_normal, &mut self.by_velocity);
        // Without sliding, a third of the work.
        if self.programs.motion < Motion::Sliding {
            for k in 0..BLOCK {
                let by_push = ax[k] * nx[k] + ay[k] * ny[k] + az[k] * nz[k];
                let by_separating = push_v[k] * by_push;
                self.by_distance[k] = push_r[k] * by_push;
                bvx[k] = by_separating * nx[k];
                bvy[k] = by_separating * ny[k];
                bvz[k] = by_separating * nz[k];
                bnx[k] = push[k] * ax[k] + by_separating * vx[k];
                bny[k] = push[k] * ay[k] + by_separating * vy[k];
                bnz[k] = push[k] * az[k] + by_separating * vz[k];
            }
            return;
        }
        for k in 0..BLOCK {
            let by_push = ax[k] * nx[k] + ay[k] * ny[k] + az[k] * nz[k];
            let by_drag = ax[k] * sx[k] + ay[k] * sy[k] + az[k] * sz[k];
            self.by_distance[k] = push_r[k] * by_push + drag_r[k] * by_drag;
            let bend = 2.0 * (push_s[k] * by_push + drag_s[k] * by_drag);
            let by_sliding =
                [drag[k] * ax[k] + bend * sx[k], drag[k] * ay[k] + bend * sy[k], drag[k] * az[k] + bend * sz[k]];
            let along = by_sliding[0] * nx[k] + by_sliding[1] * ny[k] + by_sliding[2] * nz[k];
            let by_separating = push_v[k] * by_push + drag_v[k] * by_drag - along;
            let separating = vx[k] * nx[k] + vy[k] * ny[k] + vz[k] * nz[k];
            bvx[k] = by_sliding[0] + by_separating * nx[k];
            bvy[k] = by_sliding[1] + by_separating * ny[k];
            bvz[k] = by_sliding[2] + by_separating * nz[k];
            bnx[k] = push[k] * ax[k] - separating * by_sliding[0] + by_separating * vx[k];
            bny[k] = push[k] * ay[k] - separating * by_sliding[1] + by_separating * vy[k];
            bnz[k] = push[k] * az[k] - separating * by_sliding[2] + by_separating * vz[k];
        }
    }

    /// Adds `∂J/∂c = Σ N̄ ∂N/∂c + ḡ ∂(T/|v_t|)/∂c` over the first `count` meetings for every constant c, N̄ and ḡ as in
    /// [`Meetings::pull`]; a constant that the reach depends on moves the overlap too.
    pub(super) fn pull_constants(&mut self, count: usize, constants: &mut [f64]) {
        self.run();
        let dot = |k: usize, rows: &Rows| self.acceleration.get(k).dot(rows.get(k));
        let along = |direction: usize| -> f64 {
            let [push, drag] = [0, 1].map(|n| self.program.output(&self.workspace, OUTPUTS * (1 + direction) + n));
            (0..count).map(|k| push[k] * dot(k, &self.normal) + drag[k] * dot(k, &self.sliding)).sum()
        };
        let slopes = self.programs.reach_slopes();
        let by_reach = along(slopes.len());
        for (c, (sum, slope)) in constants.iter_mut().zip(slopes).enumerate() {
            *sum += along(c) + slope * by_reach;
        }
    }

    /// Turns `∂J/∂normal` after [`Meetings::pull`] into `∂J/∂x` of the offset x that the normal turns with,
    /// `(n̄ − n (n·n̄))/r + r̄ n`.
    pub(super) fn by_offset(&mut self) {
        let (Rows([nx, ny, nz]), Rows([bx, by, bz])) = (&self.normal, &mut self.by_normal);
        for k in 0..BLOCK {
            let inverse = 1.0 / self.distance[k];
            let along = nx[k] * bx[k] + ny[k] * by[k] + nz[k] * bz[k];
            let radial = self.by_distance[k] - along * inverse;
            bx[k] = bx[k] * inverse + radial * nx[k];
            by[k] = by[k] * inverse + radial * ny[k];
            bz[k] = bz[k] * inverse + radial * nz[k];
        }
    }

    /// What [`Meetings::pull`] found for meeting `k`.
    pub(super) fn gradient(&self, k: usize) -> ContactGrad {
        ContactGrad {
            overlap: -self.by_distance[k],
            normal: self.by_normal.get(k),
            velocity: if self.moves() { self.by_velocity.get(k) } else { DVec3::ZERO },
        }
    }
}
