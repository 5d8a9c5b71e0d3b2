//! A figure as PNG, for what takes no SVG: drawn by `resvg`, lettered with a font of our own, so that it is the same on every
//! machine.
//!
//! Only with feature `png`: what draws text well takes as long to build as the engine's geometry, and few need it.

/// Dots an inch that are allowed: from a screen to a printer.
pub const DOTS: [f64; 2] = [72.0, 1200.0];

/// Dots an inch where nothing is said: what journals ask of pictures.
pub const USUAL_DOTS: f64 = 300.0;

/// Whether this program can.
pub const CAN: bool = cfg!(feature = "png");

/// Most pixels: 400 MB while they are drawn.
#[cfg(feature = "png")]
const MOST_PIXELS: f64 = 1e8;

/// An inch [mm].
#[cfg(feature = "png")]
const INCH: f64 = 25.4;

/// Letters of western and central Europe, Greek, and the signs of figures.
#[cfg(feature = "png")]
const FONT: &[u8] = include_bytes!("../../../assets/fonts/roboto.ttf");

/// Why there are no pixels.
#[derive(Debug, thiserror::Error)]
pub enum PixelError {
    /// The program was built without them.
    #[error("this program was built without PNG; build it with `--features png`")]
    Without,
    /// Too large.
    #[error("{0} x {1} pixels: fewer dots an inch, or a smaller width, please")]
    TooMany(f64, f64),
    /// It is no drawing, or has no size. A figure of ours always is one.
    #[error("{0}")]
    NoDrawing(String),
}

/// The drawing `svg` with so many `dots` an inch.
///
/// # Errors
/// More than a hundred million pixels.
#[cfg(feature = "png")]
pub fn png(svg: &str, dots: f64) -> Result<Vec<u8>, PixelError> {
    use resvg::tiny_skia::{Color, Pixmap, Transform};
    use resvg::usvg::{Options, Tree};

    let fault = |error: &dyn std::fmt::Display| PixelError::NoDrawing(error.to_string());
    // Lengths of a page without a unit are pixels of a screen.
    let mut options = Options { dpi: 96.0, ..Options::default() };
    let fonts = options.fontdb_mut();
    fonts.load_font_data(FONT.to_vec());
    fonts.set_sans_serif_family("Roboto");
    let tree = Tree::from_str(svg, &options).map_err(|error| fault(&error))?;
    let scale = dots / f64::from(options.dpi);
    let [wide, high] =
        [tree.size().width(), tree.size().height()].map(|side| (f64::from(side) * scale).round().max(1.0));
    if wide * high > MOST_PIXELS {
        return Err(PixelError::TooMany(wide, high));
    }
    let none = || fault(&"a drawing without a size");
    let mut pixels = Pixmap::new(wide as u32, high as u32).ok_or_else(none)?;
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale as f32, scale as f32), &mut pixels.as_mut());
    encoded(&pixels, dots).map_err(|error| fault(&error))
}

/// The file, which says how large it is on paper.
#[cfg(feature = "png")]
fn encoded(pixels: &resvg::tiny_skia::Pixmap, dots: f64) -> Result<Vec<u8>, png::EncodingError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, pixels.width(), pixels.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let in_a_metre = (1000.0 * dots / INCH).round() as u32;
    let size = png::PixelDimensions { xppu: in_a_metre, yppu: in_a_metre, unit: png::Unit::Meter };
    encoder.set_pixel_dims(Some(size));
    let mut writer = encoder.write_header()?;
    // The paper is white and opaque: nothing shines through.
    let colours: Vec<u8> = pixels.data().chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    writer.write_image_data(&colours)?;
    writer.finish()?;
    Ok(file)
}

/// No pixels in this build.
///
/// # Errors
/// Always.
#[cfg(not(feature = "png"))]
pub fn png(_svg: &str, _dots: f64) -> Result<Vec<u8>, PixelError> {
    Err(PixelError::Without)
}
