//! A graph network that says something without having learned anything.
use pliant::compare::ContenderSpec;
use pliant::config;
use pliant::model::WorldModel;
use pliant::state::stream;
use rand::Rng;

/// The graph network over these kinds of edges within `radius` \[m\], with changes; its weights are drawn by the stream of `purpose`.
///
/// Fresh weights are silent, and what is silent is not computed: for who measures speed.
pub(crate) fn speaking(
    kinds: &[&str],
    radius: f64,
    changes: &[String],
    purpose: &[u8; 8],
) -> anyhow::Result<Box<dyn WorldModel>> {
    let words = [
        format!("dynamics.graph={{kind=radius,radius={radius},edges={kinds:?}}}"),
        format!("dynamics.laws.0.edges={kinds:?}"),
        format!("dynamics.laws.0.radius={radius}"),
    ];
    let words = [&words[..], changes].concat();
    let spec = config::load::<ContenderSpec>("configs/model/learned.toml".as_ref(), &words)?.spec;
    Ok(shaken(spec.dynamics.build()?, purpose))
}

/// The model with its weights changed a little by the stream of `purpose`, so that none is silent.
pub(crate) fn shaken(mut model: Box<dyn WorldModel>, purpose: &[u8; 8]) -> Box<dyn WorldModel> {
    let mut rng = stream(1, &[u64::from_le_bytes(*purpose)]);
    let shaken: Vec<f32> = model.weights().iter().map(|w| w + rng.random_range(-0.01..0.01)).collect();
    model.set_weights(&shaken);
    model
}
