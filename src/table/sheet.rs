//! A contact sheet: rollouts as rows of small pictures in one PNG.
use super::picture::project;
use crate::shape::hack;
use anyhow::Context;
use glam::{DVec2, DVec3};

/// One row of the sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Strip {
    /// What the row shows.
    pub title: String,
    /// Frames from left to right.
    pub frames: Vec<Frame>,
}

/// One picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Positions \[m\] and the number of the body that each belongs to, which decides its colour.
    pub particles: Vec<(DVec3, u32)>,
    /// Points of the tool's surface \[m\].
    pub tool: Vec<DVec3>,
}

/// Side of a picture, and height of a row's title \[pixels\].
const SIDE: usize = 180;
const TITLE: usize = 18;
const COLOURS: [[f64; 3]; 3] = [[224.0, 142.0, 58.0], [66.0, 133.0, 196.0], [92.0, 158.0, 92.0]];
const TOOL: [f64; 3] = [96.0, 100.0, 108.0];

/// The PNG file of `strips`, one below the other.
///
/// # Errors
/// When the font or the picture cannot be made.
pub fn sheet(strips: &[Strip]) -> anyhow::Result<Vec<u8>> {
    let font = hack()?;
    let columns = strips.iter().map(|strip| strip.frames.len()).max().unwrap_or_default().max(1);
    let mut canvas = Canvas::white(columns * SIDE, strips.len().max(1) * (SIDE + TITLE));
    for (row, strip) in strips.iter().enumerate() {
        let top = row * (SIDE + TITLE);
        canvas.text(&font, &strip.title, 6, top + TITLE - 5);
        let reach = strip.frames.first().map_or(0.05, half_width);
        for (column, frame) in strip.frames.iter().enumerate() {
            canvas.frame(frame, DVec2::new((column * SIDE) as f64, (top + TITLE) as f64), reach);
        }
    }
    canvas.png()
}

/// Metres from the middle of a picture to its edge, so that the start and some room around it fit.
fn half_width(frame: &Frame) -> f64 {
    let reach = frame.particles.iter().map(|(p, _)| p.length()).filter(|r| r.is_finite()).fold(0.0, f64::max);
    1.25 * reach.max(0.03)
}

struct Canvas {
    width: usize,
    height: usize,
    /// Red, green and blue of each pixel, row by row.
    pixels: Vec<u8>,
}

impl Canvas {
    fn white(width: usize, height: usize) -> Self {
        Self { width, height, pixels: vec![255; 3 * width * height] }
    }

    /// Mixes `colour` into a pixel; outside of the canvas nothing.
    fn blend(&mut self, x: i64, y: i64, colour: [f64; 3], share: f64) {
        let inside = (0..self.width as i64).contains(&x) && (0..self.height as i64).contains(&y);
        if inside {
            let at = 3 * (y as usize * self.width + x as usize);
            for (pixel, wanted) in self.pixels[at..at + 3].iter_mut().zip(colour) {
                *pixel = (f64::from(*pixel) * (1.0 - share) + wanted * share).round() as u8;
            }
        }
    }

    /// Far points first; each a ball lit from the upper left, cut off at the picture's edge.
    fn frame(&mut self, frame: &Frame, corner: DVec2, reach: f64) {
        let scale = SIDE as f64 / (2.0 * reach);
        let particles = frame.particles.iter().map(|(p, body)| (*p, COLOURS[*body as usize % COLOURS.len()], 0.0042));
        let tool = frame.tool.iter().map(|p| (*p, TOOL, 0.0022));
        let mut balls: Vec<_> = particles.chain(tool).filter(|(p, ..)| p.is_finite()).collect();
        balls.sort_by(|a, b| project(a.0).1.total_cmp(&project(b.0).1));
        let edge = DVec2::splat(SIDE as f64);
        for (p, colour, radius) in balls {
            let flat = project(p).0;
            let middle = DVec2::new(0.5 * SIDE as f64 + scale * flat.x, 0.7 * SIDE as f64 - scale * flat.y);
            let radius = (scale * radius).max(1.0);
            let (low, high) = ((middle - radius).floor(), (middle + radius).ceil());
            for y in low.y as i64..=high.y as i64 {
                for x in low.x as i64..=high.x as i64 {
                    let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                    let off = (pixel - middle) / radius;
                    let inside = pixel.cmpge(DVec2::ZERO).all() && pixel.cmplt(edge).all();
                    if inside && off.length_squared() <= 1.0 {
                        let rise = (1.0 - off.length_squared()).sqrt();
                        let light = 0.45 + 0.55 * (0.6 * rise - 0.5 * off.x - 0.6 * off.y).clamp(0.0, 1.0);
                        let at = corner + pixel;
                        self.blend(at.x as i64, at.y as i64, colour.map(|c| c * light), 1.0);
                    }
                }
            }
        }
    }

    /// A line of text that starts at `x` on the base line `y`.
    fn text(&mut self, font: &fontdue::Font, text: &str, x: usize, y: usize) {
        let mut pen = x as f64;
        for character in text.chars() {
            let (metrics, coverage) = font.rasterize(character, 12.0);
            for (i, share) in coverage.iter().enumerate() {
                let (across, down) = ((i % metrics.width) as i64, (i / metrics.width) as i64);
                let top = y as i64 - i64::from(metrics.ymin) - metrics.height as i64;
                let left = pen as i64 + i64::from(metrics.xmin);
                self.blend(left + across, top + down, [30.0; 3], f64::from(*share) / 255.0);
            }
            pen += f64::from(metrics.advance_width);
        }
    }

    fn png(&self) -> anyhow::Result<Vec<u8>> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        let mut writer = encoder.write_header().context("the contact sheet cannot be encoded")?;
        writer.write_image_data(&self.pixels).context("the contact sheet cannot be encoded")?;
        writer.finish().context("the contact sheet cannot be encoded")?;
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(title: &str, particles: &[(DVec3, u32)]) -> Strip {
        Strip { title: title.into(), frames: vec![Frame { particles: particles.to_vec(), tool: Vec::new() }; 2] }
    }

    fn decoded(strips: &[Strip]) -> (u32, u32, Vec<u8>) {
        let file = sheet(strips).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        (info.width, info.height, pixels)
    }

    #[test]
    fn every_strip_has_its_row_and_every_body_its_colour() {
        let strips = [strip("", &[(DVec3::ZERO, 0)]), strip("", &[(DVec3::ZERO, 1), (DVec3::NAN, 0)])];
        let (width, height, pixels) = decoded(&strips);
        assert_eq!((width as usize, height as usize), (2 * SIDE, 2 * (SIDE + TITLE)));
        let row = |k: usize| &pixels[k * pixels.len() / 2..(k + 1) * pixels.len() / 2];
        let redder = |row: &[u8]| row.chunks(3).filter(|p| p[0] > p[2]).count();
        let bluer = |row: &[u8]| row.chunks(3).filter(|p| p[0] < p[2]).count();
        assert!(redder(row(0)) > 50 && bluer(row(0)) == 0, "dough in the first row");
        assert!(bluer(row(1)) > 50 && redder(row(1)) == 0, "water in the second, and no ball for a NaN");
    }

    #[test]
    fn a_title_is_written_and_a_near_ball_covers_a_far_one() {
        let dark = |title: &str| decoded(&[strip(title, &[])]).2.iter().filter(|c| **c < 128).count();
        assert_eq!(dark(""), 0);
        assert!(dark("knife") > 60);
        // Seen from −y and above.
        let (near, far) = (DVec3::new(0.0, -0.01, 0.0), DVec3::new(0.0, -0.009, 0.0));
        let blue = |balls: &[(DVec3, u32)]| decoded(&[strip("", balls)]).2.chunks(3).filter(|p| p[0] < p[2]).count();
        assert!(blue(&[(near, 1), (far, 0)]) > 3 * blue(&[(near, 0), (far, 1)]));
    }
}
