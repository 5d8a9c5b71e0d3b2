//! An accuracy in words: `run --accuracy`; see [`calibration`](super::calibration).

/// An accuracy as a user asks for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// Largest error of a bullet before contact [m].
    Length(f64),
    /// The same over the side of the net [-].
    Share(f64),
}

impl std::str::FromStr for Accuracy {
    type Err = String;

    /// `1mm`, `50um`, `0.001m`; or `fast`, `standard`, `fine`: a thousandth, a ten-thousandth, a
    /// hundred-thousandth of the net's side.
    fn from_str(text: &str) -> Result<Accuracy, String> {
        match text {
            "fast" => return Ok(Accuracy::Share(1e-3)),
            "standard" => return Ok(Accuracy::Share(1e-4)),
            "fine" => return Ok(Accuracy::Share(1e-5)),
            _ => {}
        }
        let units = [("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6), ("cm", 1e-2), ("m", 1.0)];
        let length = units
            .into_iter()
            .find_map(|(unit, factor)| Some(factor * text.strip_suffix(unit)?.trim().parse::<f64>().ok()?));
        match length {
            Some(length) if length.is_finite() && length > 0.0 => Ok(Accuracy::Length(length)),
            _ => Err("fast, standard, fine, or a length above 0 with its unit, as in 1mm or 50um".to_owned()),
        }
    }
}

impl Accuracy {
    /// For a net of side `side` metres [m].
    pub fn length(self, side: f64) -> f64 {
        match self {
            Accuracy::Length(length) => length,
            Accuracy::Share(share) => share * side,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accuracies_are_read_with_their_units() {
        let read = |text: &str| text.parse::<Accuracy>();
        assert_eq!(read("1mm"), Ok(Accuracy::Length(1e-3)));
        assert_eq!(read("50um").unwrap().length(3.0), 50.0 * 1e-6);
        assert_eq!(read("standard").unwrap().length(10.0), 1e-3);
        for bad in ["", "1", "-1mm", "mm", "0m", "NaNm", "finest"] {
            assert!(read(bad).is_err(), "{bad}");
        }
    }
}
