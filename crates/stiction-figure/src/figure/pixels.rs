//! Pictures as pixels: what the rasteriser leaves to be done.

use std::io::Cursor;

/// CSS px to the metre: 96 to the inch.
const PX_PER_METRE: f64 = 96.0 / 0.0254;

/// An opaque picture.
pub(super) struct Pixels {
    width: usize,
    height: usize,
    /// Three bytes a pixel, row by row.
    rgb: Vec<u8>,
}

impl Pixels {
    /// Reads an opaque RGBA picture.
    pub fn from_png(png: &[u8]) -> Result<Self, png::DecodingError> {
        let mut reader = png::Decoder::new(Cursor::new(png)).read_info()?;
        let mut rgba = vec![0; reader.output_buffer_size().unwrap_or(0)];
        let info = reader.next_frame(&mut rgba)?;
        let rgb = rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        Ok(Self { width: info.width as usize, height: info.height as usize, rgb })
    }

    /// Prints `other`, dark on white, turned a quarter to the left, so that its pixel
    /// (`column`, `row`) comes to lie at (`x`, `y`).
    pub fn print_upright(&mut self, other: &Self, (column, row): (i64, i64), (x, y): (i64, i64)) {
        for (r, line) in other.rgb.chunks_exact(3 * other.width).enumerate() {
            for (c, pixel) in line.chunks_exact(3).enumerate() {
                let (px, py) = (x + r as i64 - row, y - (c as i64 - column));
                let inside =
                    (0..self.width as i64).contains(&px) && (0..self.height as i64).contains(&py);
                if inside {
                    let at = 3 * (py as usize * self.width + px as usize);
                    for (old, new) in self.rgb[at..at + 3].iter_mut().zip(pixel) {
                        *old = (*old).min(*new);
                    }
                }
            }
        }
    }

    /// The picture with blocks of `factor` by `factor` pixels averaged to one.
    pub fn shrunk(&self, factor: usize) -> Self {
        let (width, height) = (self.width / factor, self.height / factor);
        let mut rgb = Vec::with_capacity(3 * width * height);
        let count = (factor * factor) as u32;
        for row in 0..height {
            for column in 0..width {
                let mut sum = [0u32; 3];
                for y in row * factor..(row + 1) * factor {
                    let start = 3 * (y * self.width + column * factor);
                    for pixel in self.rgb[start..start + 3 * factor].chunks_exact(3) {
                        for (sum, value) in sum.iter_mut().zip(pixel) {
                            *sum += u32::from(*value);
                        }
                    }
                }
                rgb.extend(sum.map(|s| ((s + count / 2) / count) as u8));
            }
        }
        Self { width, height, rgb }
    }

    /// The picture as a PNG file, marked as having `density` pixels to the px.
    pub fn to_png(&self, density: f64) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        let per_metre = (density * PX_PER_METRE).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: png::Unit::Meter,
        }));
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: usize, values: &[u8]) -> Pixels {
        let rgb: Vec<u8> = values.iter().flat_map(|v| [*v; 3]).collect();
        Pixels { width, height: values.len() / width, rgb }
    }

    #[test]
    fn blocks_are_averaged() {
        let small = grey(4, &[0, 100, 8, 8, 100, 200, 8, 9]).shrunk(2);
        assert_eq!((small.width, small.height, small.rgb), (2, 1, vec![100, 100, 100, 8, 8, 8]));
    }

    #[test]
    fn upright_text_reads_upwards() {
        let mut sheet = grey(3, &[255; 9]);
        sheet.print_upright(&grey(2, &[1, 2]), (0, 0), (1, 2));
        assert_eq!(sheet.rgb, grey(3, &[255, 255, 255, 255, 2, 255, 255, 1, 255]).rgb);
    }
}
