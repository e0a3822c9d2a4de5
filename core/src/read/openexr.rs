//! OpenEXR images of attributes: numbers of any size, gray or with up to four components.
//!
//! Format: <https://openexr.com/en/latest/OpenEXRFileLayout.html>. Read by the `exr` library, after sizes were checked.

use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::header::Header;
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, SampleType, Vec2, read};

use super::Limits;
use super::images::check_size;
use super::text::quoted;
use crate::asset::VALUE_SCALES;
use crate::error::{Error, Result};
use crate::image::{Image, Pixels, Values};

const MARK: [u8; 4] = [0x76, 0x2F, 0x31, 0x01];

/// Components by the names of channels as files have them, which is in alphabetical order; and where each goes.
const CHANNELS: [(&[&str], &[usize]); 6] = [
    (&["A", "Y"], &[1, 0]),
    (&["G", "R"], &[1, 0]),
    (&["X", "Y"], &[0, 1]),
    (&["B", "G", "R"], &[2, 1, 0]),
    (&["X", "Y", "Z"], &[0, 1, 2]),
    (&["A", "B", "G", "R"], &[3, 2, 1, 0]),
];

pub(super) fn is_openexr(bytes: &[u8]) -> bool {
    bytes.starts_with(&MARK)
}

/// The size of a file that [`decode`] takes, within the limits.
///
/// # Errors
/// `InvalidModel` where the file is broken, or has more than one flat image with 1 to 4 channels of half or float numbers
/// that fill its window; `ImageTooLarge`.
pub(super) fn size(bytes: &[u8], limits: &Limits, pointer: &str) -> Result<[u32; 2]> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(broken)?;
    let [header] = meta.headers.as_slice() else {
        return Err(Error::invalid(format!(
            "the OpenEXR file has {} parts; give it one",
            meta.headers.len()
        )));
    };
    let whole = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    let Vec2(width, height) = header.layer_size;
    let size = [whole(width), whole(height)];
    check_size(size, limits, pointer)?;
    check(header)?;
    Ok(size)
}

fn broken(error: exr::error::Error) -> Error {
    Error::invalid(format!("the OpenEXR file cannot be decoded: {error}"))
}

fn check(header: &Header) -> Result<()> {
    if header.deep {
        return Err(Error::invalid("the OpenEXR file holds deep data; flat images are read"));
    }
    let window = header.shared_attributes.display_window;
    if window.size != header.layer_size || window.position != header.own_attributes.layer_position {
        return Err(Error::invalid(
            "the OpenEXR file's data window is not its display window, so texture coordinates have no certain meaning; crop or \
             fill it",
        ));
    }
    let channels = &header.channels.list;
    placement(&channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>())?;
    for channel in channels {
        let name = quoted(&channel.name.to_string());
        if channel.sample_type == SampleType::U32 {
            return Err(Error::invalid(format!(
                "channel {name} holds whole numbers; half and float are read"
            )));
        }
        if channel.sampling != Vec2(1, 1) {
            return Err(Error::invalid(format!(
                "channel {name} is subsampled; give it a value for each pixel"
            )));
        }
    }
    Ok(())
}

/// Where the components of channels go.
fn placement(names: &[String]) -> Result<&'static [usize]> {
    if names.len() == 1 {
        return Ok(&[0]);
    }
    let known = CHANNELS.iter().find(|(known, _)| known.iter().eq(names));
    known.map(|(_, places)| *places).ok_or_else(|| {
        let listed: Vec<String> = names.iter().take(8).map(|name| quoted(name)).collect();
        Error::invalid(format!(
            "the OpenEXR file has {} channels ({}); read are one of any name, Y A, R G, X Y, R G B, X Y Z and R G B A",
            names.len(),
            listed.join(", ")
        ))
    })
}

/// Decodes a file whose [`size`] was found. Two components that are no gray with alpha get a blue of 0.
///
/// # Errors
/// `InvalidModel` where the file is broken or holds what is not a number within ±2^100.
pub(super) fn decode(bytes: &[u8]) -> Result<Image> {
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
    let image = reader.all_attributes().non_parallel().from_buffered(Cursor::new(bytes)).map_err(broken)?;
    let Vec2(width, height) = image.layer_data.size;
    let channels = &image.layer_data.channel_data.list;
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    let places = placement(&names)?;
    let is_pair = places.len() == 2 && names != ["A", "Y"];
    let components = if is_pair { 3 } else { places.len() };
    let mut values = vec![0.0f32; width * height * components];
    for (channel, &place) in channels.iter().zip(places) {
        let texels = values.iter_mut().skip(place).step_by(components);
        match &channel.sample_data {
            FlatSamples::F16(samples) => texels.zip(samples).for_each(|(to, value)| *to = value.to_f32()),
            FlatSamples::F32(samples) => texels.zip(samples).for_each(|(to, value)| *to = *value),
            FlatSamples::U32(_) => return Err(Error::invalid("the OpenEXR file holds whole numbers")),
        }
    }
    let scale = scale_of(&values, width * components)?;
    values.iter_mut().for_each(|value| *value /= scale);
    let pixels = Pixels::F32(Values { values, bits: 16, texels_per_painted: 1, scale: Some(scale) });
    let side = |side: usize| u32::try_from(side).map_err(|_| Error::invalid("the OpenEXR file is too large"));
    Ok(Image { width: side(width)?, height: side(height)?, components: components as u8, pixels })
}

/// The least power of two that is not under any number's size, or under 2^-100.
fn scale_of(values: &[f32], row_count: usize) -> Result<f32> {
    let [least, most] = VALUE_SCALES;
    let is_sound = |value: &f32| value.abs() <= most;
    if let Some(place) = values.iter().position(|value| !is_sound(value)) {
        return Err(Error::invalid(format!(
            "the OpenEXR file holds {} in row {} from the top; allowed are numbers within ±{most:e}",
            values[place],
            place / row_count.max(1)
        )));
    }
    let largest = values.iter().fold(least, |largest, value| largest.max(value.abs()));
    // A float's lower 23 bits are 0 where it is a power of two; its exponent is above them.
    let power = f32::from_bits(largest.to_bits() & 0xFF80_0000);
    Ok(if values.iter().all(|value| *value == 0.0) {
        1.0
    } else if power == largest {
        power
    } else {
        (2.0 * power).min(most)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scale_is_the_least_power_of_two_over_all_numbers() {
        let [least, most] = VALUE_SCALES;
        let cases: [(&[f32], f32); 7] = [
            (&[0.0, 0.0], 1.0),
            (&[0.3, -0.2], 0.5),
            (&[0.5, 0.2], 0.5),
            (&[-64.1, 3.0], 128.0),
            (&[1e-38, 0.0], least),
            (&[most], most),
            (&[1.0], 1.0),
        ];
        for (values, scale) in cases {
            assert_eq!(scale_of(values, 1).unwrap(), scale, "{values:?}");
        }
        for bad in [f32::NAN, f32::INFINITY, 2e30] {
            let detail = scale_of(&[0.0, 1.0, bad], 2).unwrap_err().detail;
            assert!(detail.contains("in row 1 from the top"), "{detail}");
        }
    }
}
