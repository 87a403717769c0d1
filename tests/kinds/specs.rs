//! One model of each of the other kinds of learned model.
use pliant::model::{ModelSpec, WorldModel};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(crate) const PICTURE: &str = "[picture]\ngrid = { cell = 0.008, rows = 16, columns = 20, height = 0.045, levels = 3 }\n\
                                  top = 0.013\nreach = 0.02\nscale = 0.004\n";

pub(crate) fn read(head: &str, picture: &str) -> ModelSpec {
    toml_edit::de::from_str(&format!("{head}\n{picture}")).unwrap()
}

/// Untrained.
pub(crate) fn specs() -> [(&'static str, ModelSpec); 4] {
    let latent = "kind = \"latent\"\ncode = 6\nwidth = 12\nextent = 0.04\nscale = 0.004\nseed = 1";
    let view = PICTURE.replace("[picture]", "[view]\nkind = \"picture\"").replace("reach = 0.02\nscale = 0.004\n", "");
    [
        ("linear", read("kind = \"linear\"\nwidth = 5", PICTURE)),
        ("unet", read("kind = \"unet\"\nwidth = 4\ndepth = 2\nseed = 1", PICTURE)),
        ("latent", read(latent, "")),
        ("latent_picture", read(latent, &view)),
    ]
}

/// The same out of its zero start.
pub(crate) fn shaken(spec: &ModelSpec) -> Box<dyn WorldModel> {
    let mut model = spec.clone().build().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let weights: Vec<f32> = model.weights().iter().map(|w| w + rng.random_range(-0.1..0.1)).collect();
    model.set_weights(&weights);
    model
}
