//! The network: typed message passing over a particle graph, with exact derivatives of weights and inputs.
//!
//! ```text
//! h⁰ᵢ = MLP_enc(nodeᵢ)
//! mᵢⱼ = c w(rᵢⱼ) MLP_k([hᵢ, hⱼ, fᵢⱼ])        one edge network a kind k
//! hᵢ ← hᵢ + MLP_u([hᵢ, Σ_k Σ_j mᵢⱼ])           particles and roots; tool, walls and floor keep h⁰
//! out_i = MLP_dec(hᵢ) ∈ ℝ³
//! ```
//!
//! [`Aggregation`] says what may stand for the sum of messages; the kinds may share one edge network, which a flag tells the kind, and
//! what networks read of h may be normalised first. Interaction networks (Battaglia et al. 2016) with the
//! encode–process–decode layout of Sanchez-Gonzalez et al. 2020. The window w reaches zero with zero slope at the graph's radius, so
//! that outputs stay continuous and differentiable when an edge appears or vanishes; edges of roots and bonds have no window.
//! Operations run on one thread and share nothing, so callers parallelise over rollouts.
mod aggregate;
mod aggregation;
#[cfg(test)]
mod agreement;
mod architecture;
mod bfloat16;
mod dense;
mod ends;
mod features;
mod filter;
mod input;
mod latent;
mod layer_norm;
mod layers;
mod message;
mod mixing;
mod multilayer_perceptron;
#[cfg(test)]
mod naive;
mod network;
mod parameters;
mod part;
mod picture;
mod point_net;
mod pool;
mod precision;
mod product;
mod record;
mod rounded;
mod squareplus;
mod three_layers;
mod traced;
mod unet;
mod weights;

pub use aggregation::Aggregation;
pub use architecture::{Architecture, Sharing};
pub(crate) use features::Features;
pub(crate) use filter::{Filter, FilterArchitecture};
pub use input::{Edges, EdgesGrad, Input, InputGrad, Links};
pub(crate) use latent::{
    Advance, Decode, DecodePicture, Encode, EncodePicture, LatentArchitecture, LatentNet, PictureSize, SAMPLE,
};
pub(crate) use layers::{Layers, Trainable, forward, pull};
pub(crate) use mixing::Mixing;
pub(crate) use multilayer_perceptron::Stack;
pub use network::Network;
pub(crate) use picture::Size;
pub(crate) use point_net::{Judge, PointNet, PointNetArchitecture};
pub use precision::Precision;
pub use record::Wanted;
pub use traced::Traced;
pub(crate) use unet::{UNet, UNetArchitecture};
