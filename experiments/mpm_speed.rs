//! Claim: the material point method makes at least twice as many particle steps a CPU second as Taichi's on the same block of
//! points and the same grid, and a gradient costs at most four rollouts.
//!
//! Command: `pip install taichi==1.7.4` (for Python 3.7 to 3.13), then `cargo run --release --bin experiments -- mpm_speed`, about
//! five minutes; the interpreter by `python=PATH`. Table: `paper/tables/mpm_speed.tex`. Linux only: CPU time is read from `/proc`.
use crate::claim::{Experiment, Rows, Size, median, number, verdict_on};
use crate::cpu::cpu_seconds;
use crate::peer::Peer;
use anyhow::{Context, ensure};
use glam::DVec3;
use pliant::model::mpm::{MpmModel, MpmSpec, Precision, SurfaceSpec};
use pliant::model::{Checkpoints, Cost, Dynamics, WorldModel};
use pliant::state::{Control, Particles, ParticlesGrad, Scene, ToolShape};
use pliant::table::Grid;
use pliant::watch::Watch;
use serde_json::{Value, json};
use std::sync::Arc;

pub(crate) const CLAIM: Experiment = Experiment {
    name: "mpm_speed",
    claim: "the material point method runs at 2 × the speed of Taichi's on a CPU, and a gradient costs ≤ 4 rollouts",
    duration: "about 5 minutes",
    rows: Rows::Beside(measure),
    table,
};

/// Node distance \[m\]; eight points a cell, as in Taichi's example.
const CELL: f64 = 0.01;
/// Points along an edge of the block: 512, 8000 (as many as the example has) and 32 768 in all.
const SIDES: &[usize] = &[8, 20, 32];
/// Taichi's programs: its example, and our law in it.
const VARIANTS: [(&str, &str); 2] = [("example", "Taichi's example"), ("dough", "our law in Taichi")];
const CLAIMED: f64 = 2.0;
const GRADIENT: f64 = 4.0;

fn measure(size: Size, peer: &Peer, watch: &Watch) -> anyhow::Result<Vec<Value>> {
    let (sides, controls, rounds) = match size {
        Size::Paper => (SIDES, 4, 3),
        Size::Smoke => (&[3][..], 1, 1),
    };
    let mut rows = Vec::new();
    for round in 0..rounds {
        for &side in sides {
            watch.go_on(|| "stopped between two measurements; nothing is kept of them".into())?;
            let block = Block::of(side)?;
            let mut made =
                vec![block.ours("ours", &block.model, controls)?, block.ours("single", &block.single, controls)?];
            // A rehearsal needs no interpreter.
            if size == Size::Paper {
                made.extend(block.theirs(peer)?);
            }
            rows.extend(made.into_iter().map(|mut row| {
                (row["particles"], row["round"]) = (json!(side.pow(3)), json!(round));
                row
            }));
        }
    }
    Ok(rows)
}

/// A block of points that sinks onto the table.
struct Block {
    spec: MpmSpec,
    model: MpmModel,
    /// The same in single precision.
    single: MpmModel,
    scene: Scene,
}

impl Block {
    fn of(side: usize) -> anyhow::Result<Self> {
        let slippery = SurfaceSpec::Coulomb { friction: 0.0 };
        let spec = MpmSpec {
            cell: CELL,
            courant: 0.3,
            density: 1200.0,
            young_modulus: 5e3,
            poisson_ratio: 0.3,
            yield_stress: 50.0,
            viscosity: 0.0,
            gravity: 1.0,
            table: slippery.clone(),
            tool: slippery,
            softness: 0.001,
            precision: Precision::Double,
            checkpoints: Checkpoints::default(),
        };
        let place = |n: usize| DVec3::new((n % side) as f64, (n / side % side) as f64, (n / side / side) as f64);
        let positions = (0..side.pow(3)).map(|n| 0.5 * CELL * (place(n) + 0.5)).collect();
        let none = Arc::new(ToolShape::from(Vec::new()));
        let scene = Scene::open(Particles::at_rest(positions), none, Vec::new(), 0.1);
        let single = MpmModel::new(MpmSpec { precision: Precision::Single, ..spec.clone() })?;
        Ok(Self { model: MpmModel::new(spec.clone())?, single, spec, scene })
    }

    fn steps(&self) -> usize {
        self.model.substeps(self.scene.interval)
    }

    /// Speed over one control step, and the price of a gradient over some, in rollouts over as many.
    fn ours(&self, variant: &str, model: &MpmModel, controls: usize) -> anyhow::Result<Value> {
        let control = Control::default();
        let start = model.encode(&self.scene);
        let clock = cpu_seconds()?;
        let end = model.step(&start, &control);
        let used = cpu_seconds()? - clock;
        let controls = vec![control; controls];
        let clock = cpu_seconds()?;
        let rollout = model.rollout(&self.scene, &controls);
        let forward = cpu_seconds()? - clock;
        let clock = cpu_seconds()?;
        let gradient = WorldModel::gradient(model, &self.scene, &controls, &Height);
        let both = cpu_seconds()? - clock;
        let gradient = gradient.context("the model has lost its adjoint")?;
        ensure!((gradient.cost - Height.total(&rollout)).abs() <= 1e-9 * gradient.cost, "the sweep's cost is another");
        let after = model.decode(&end).positions;
        let moved = after.iter().zip(&self.scene.particles.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        let speed = (self.scene.particles.len() * self.steps()) as f64 / used;
        Ok(
            json!({ "engine": "pliant", "variant": variant, "particle_steps_per_second": speed, "gradient": both / forward,
            "moved": moved }),
        )
    }

    fn theirs(&self, peer: &Peer) -> anyhow::Result<Vec<Value>> {
        let MpmSpec { cell, density, young_modulus, poisson_ratio, yield_stress, gravity, .. } = &self.spec;
        let positions: Vec<_> = self.scene.particles.positions.iter().map(DVec3::to_array).collect();
        let (steps, variants) = (self.steps(), VARIANTS.map(|(variant, _)| variant));
        let scene = json!({ "positions": positions, "cell": cell, "dt": self.scene.interval / steps as f64, "steps": steps,
            "density": density, "young": young_modulus, "poisson": poisson_ratio, "yield": yield_stress, "gravity": gravity,
            "variants": variants });
        let end = self.model.decode(&self.model.step(&self.model.encode(&self.scene), &Control::default()));
        let mut rows = peer.run("taichi_mpm.py", &scene)?;
        for row in &mut rows {
            let positions = row.as_object_mut().and_then(|row| row.remove("positions")).unwrap_or_default();
            let positions: Vec<DVec3> = serde_json::from_value(positions).context("the peer gave no positions")?;
            ensure!(positions.len() == end.len(), "the peer moved {} points of {}", positions.len(), end.len());
            let gap = positions.iter().zip(&end.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            if row["variant"] == "dough" {
                row["gap"] = json!(gap);
            }
            row["particle_steps_per_second"] = json!((end.len() * steps) as f64 / number(row, "cpu_seconds"));
        }
        Ok(rows)
    }
}

/// How high all points are, in every state.
struct Height;

impl Cost for Height {
    fn at(&self, _: usize, _: usize, particles: &Particles) -> f64 {
        particles.positions.iter().map(|x| x.z).sum()
    }

    fn gradient(&self, _: usize, _: usize, particles: &Particles) -> ParticlesGrad {
        ParticlesGrad { positions: vec![DVec3::Z; particles.len()], ..ParticlesGrad::zero(particles.len()) }
    }
}

fn table(rows: &[Value]) -> anyhow::Result<Grid> {
    let of = |count: f64, variant: &'static str, key: &'static str| {
        let same = rows.iter().filter(move |row| number(row, "particles") == count && row["variant"] == variant);
        median(same.map(|row| number(row, key)).collect())
    };
    let mut counts: Vec<f64> = rows.iter().map(|row| number(row, "particles")).collect();
    counts.sort_by(f64::total_cmp);
    counts.dedup();
    let speed = "particle_steps_per_second";
    let shown = |number: f64| if number.is_finite() { format!("{number:.2}") } else { "–".into() };
    let ratio = |count: f64, variant| of(count, "ours", speed) / of(count, variant, speed);
    let line = |&count: &f64| {
        let (double, single) = (of(count, "ours", speed), of(count, "single", speed));
        let mut cells = vec![format!("{count}"), shown(double * 1e-6), shown(single * 1e-6), shown(single / double)];
        for (variant, _) in VARIANTS {
            cells.extend([shown(of(count, variant, speed) * 1e-6), shown(ratio(count, variant))]);
        }
        cells.extend(["ours", "single"].map(|variant| shown(of(count, variant, "gradient"))));
        cells
    };
    let theirs = VARIANTS.map(|(_, name)| [name, "ratio"]);
    let header =
        [&["points", "ours [M/s]", "in single", "ratio"], &theirs.concat()[..], &["gradient [rollouts]", "in single"]];
    let worst = counts.iter().map(|&count| ratio(count, VARIANTS[0].0)).fold(f64::NAN, f64::min);
    let price = counts.iter().map(|&count| of(count, "ours", "gradient")).fold(f64::NAN, f64::max);
    let gap = rows.iter().map(|row| number(row, "gap")).fold(f64::NAN, f64::max);
    Ok(Grid {
        title: "The material point method beside Taichi's: millions of particle steps a CPU second".into(),
        header: header.concat().into_iter().map(String::from).collect(),
        rows: counts.iter().map(line).collect(),
        notes: vec![
            "one thread each, medians of rounds in the same run; same points, grid and substeps; ours in double precision where \
             nothing else is said, Taichi's in single; its example is a fluid, which has no shear to decompose"
                .into(),
            format!(
                "at least {worst:.2} times as fast as Taichi's example (claim: {CLAIMED}; {})",
                verdict_on(worst, worst >= CLAIMED)
            ),
            format!("a gradient costs {price:.2} rollouts at most (claim: {GRADIENT}; {})", verdict_on(price, price <= GRADIENT)),
            format!("our law in Taichi puts points within {:.2} % of a cell of ours", 1e2 * gap / CELL),
        ],
    })
}
