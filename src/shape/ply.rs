//! Vertices of PLY files, ASCII or binary in either byte order; every other property is ignored.
use anyhow::{Context, ensure};
use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Property, PropertyAccess, PropertyAccessResult, PropertyType};

struct Vertex(DVec3);

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self(DVec3::ZERO)
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let Some(axis) = axis(name) else { return PropertyAccessResult::Ignored };
        self.0[axis] = match value {
            Property::Float(x) => f64::from(x),
            Property::Double(x) => x,
            Property::Char(x) => f64::from(x),
            Property::UChar(x) => f64::from(x),
            Property::Short(x) => f64::from(x),
            Property::UShort(x) => f64::from(x),
            Property::Int(x) => f64::from(x),
            Property::UInt(x) => f64::from(x),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

fn axis(name: &str) -> Option<usize> {
    ["x", "y", "z"].iter().position(|&axis| axis == name)
}

pub(super) fn points(bytes: &[u8]) -> anyhow::Result<Vec<DVec3>> {
    let (mut reader, parser) = (Reader::new(bytes), Parser::<Vertex>::new());
    let header = parser.read_header(&mut reader).context("its PLY header is damaged")?;
    let has_axis = |vertex: &ElementDef, name: &str| {
        vertex.properties.get(name).is_some_and(|p| matches!(p.data_type, PropertyType::Scalar(_)))
    };
    for (name, element) in &header.elements {
        // An element takes at least one byte, unless it has no property.
        ensure!(
            element.count <= reader.get_ref().len() && !element.properties.is_empty(),
            "its header claims {} {name:?} elements but only {} bytes follow; it is truncated or damaged",
            element.count,
            reader.get_ref().len()
        );
        if name == "vertex" {
            ensure!(["x", "y", "z"].iter().all(|a| has_axis(element, a)), "its vertices lack x, y or z");
        }
        let read = parser.read_payload_for_element(&mut reader, element, &header);
        let read = read.context("it is truncated or damaged")?;
        if name == "vertex" {
            return Ok(read.into_iter().map(|v| v.0).collect());
        }
    }
    anyhow::bail!("it has no \"vertex\" element")
}
