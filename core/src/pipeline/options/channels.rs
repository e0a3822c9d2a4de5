//! The option `channel` as text: `NAME[@MATERIAL]=IMAGE[#SET]`, with commas between several.

use super::refused_because;
use super::text::NONE;
use crate::asset::Slot;
use crate::error::Result;
use crate::read::{AttributeSource, TEXCOORD_SETS_MAX};

const OPTION: &str = "channel";
const MISSING_IMAGE: &str = "there is no `=` before the image (commas stand between channels, so neither a file nor a material can be \
                             named that has one in its name)";

/// # Errors
/// `InvalidOptions` with what is wrong with which of them.
pub fn parse(value: &str) -> Result<Vec<AttributeSource>> {
    if value == NONE {
        return Ok(Vec::new());
    }
    value.split(',').map(|one| parse_one(one.trim())).collect()
}

fn parse_one(text: &str) -> Result<AttributeSource> {
    let wrong = |reason: &str| refused_because(OPTION, text, reason);
    let (target, image) = text.split_once('=').ok_or_else(|| wrong(MISSING_IMAGE))?;
    let (name, material) = match target.split_once('@') {
        Some((name, material)) => (name, Some(material.to_owned())),
        None => (target, None),
    };
    let name = match Slot::named(name) {
        Some(Slot::Attribute(name)) => name,
        Some(_) => return Err(wrong(&format!("\"{name}\" is a slot of every material, not a NAME"))),
        None => return Err(wrong(&format!("\"{name}\" is no such NAME"))),
    };
    let (file, texcoord) = match image.rsplit_once('#') {
        Some((file, set)) if !set.is_empty() && set.bytes().all(|byte| byte.is_ascii_digit()) => {
            let set = set.parse().ok().filter(|set| *set < TEXCOORD_SETS_MAX);
            (file, set.ok_or_else(|| wrong(&format!("sets are numbered 0 to {}", TEXCOORD_SETS_MAX - 1)))?)
        }
        _ => (image, 0),
    };
    if file.is_empty() {
        return Err(wrong("no file is named"));
    }
    Ok(AttributeSource { name, material, file: file.to_owned(), texcoord })
}

/// What [`parse`] reads.
pub fn text(channels: &[AttributeSource]) -> String {
    if channels.is_empty() {
        return NONE.to_owned();
    }
    let one = |source: &AttributeSource| {
        let material = source.material.as_ref().map(|name| format!("@{name}")).unwrap_or_default();
        // A file whose name ends like a set needs one.
        let is_plain = source.texcoord == 0
            && parse_one(&format!("a={}", source.file)).is_ok_and(|own| own.file == source.file);
        let set = if is_plain { String::new() } else { format!("#{}", source.texcoord) };
        format!("{}{material}={}{set}", source.name.as_str(), source.file)
    };
    channels.iter().map(one).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_channels_are_each_other() {
        for value in [
            "none",
            "thickness=thickness.png",
            "light=bakes/light.exr#1,mask@Body @ left=mask=2.png",
            "a=track#7#0",
            "a=no-set#x",
        ] {
            assert_eq!(text(&parse(value).unwrap()), value);
        }
        let parsed = parse("light=bakes/light.exr#1, mask@Body @ left=mask=2.png").unwrap();
        let [light, mask] = parsed.as_slice() else { panic!("{parsed:?}") };
        assert_eq!(
            (light.name.as_str(), light.file.as_str(), light.texcoord),
            ("light", "bakes/light.exr", 1)
        );
        assert_eq!(
            (mask.material.as_deref(), mask.file.as_str(), mask.texcoord),
            (Some("Body @ left"), "mask=2.png", 0)
        );
    }

    #[test]
    fn what_is_wrong_is_said() {
        for (value, rule) in [
            ("thickness", "no `=`"),
            ("a=x.png,", "no `=`"),
            ("normal=x.png", "\"normal\" is a slot"),
            ("1=x.png", "\"1\" is no such NAME"),
            ("a=", "no file"),
            ("a=#3", "no file"),
            ("a=x.png#16", "0 to 15"),
        ] {
            let error = parse(value).unwrap_err();
            assert_eq!(error.pointer.as_deref(), Some("/channel"));
            assert!(error.detail.contains(rule), "{value}: {}", error.detail);
        }
    }
}
