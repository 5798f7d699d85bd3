//! Extensions of materials, from JSON to the scene's materials.

use super::material::TextureUse;
use gltf_json::deserialize::from_value;
use gltf_json::extensions::material::Material as Extensions;
use gltf_json::texture::{Info, Texture};
use gltf_json::{Index, Value};
use rtrt_core::layout::COLOR_LIMIT;

/// The properties of an extension. Those that are missing or no numbers have their defaults.
#[derive(Clone, Copy)]
pub(super) struct Properties<'a>(&'a Value);

/// A texture, its use, and what a normal map is scaled by.
pub(super) struct Used {
    pub index: Index<Texture>,
    pub texture_use: TextureUse,
    pub scale: f32,
}

impl<'a> Properties<'a> {
    /// Those of an extension, if the material has it.
    pub fn of(extensions: Option<&'a Extensions>, name: &str) -> Option<Self> {
        extensions?.others.get(name).filter(|value| value.is_object()).map(Self)
    }

    /// A number, clamped to a range.
    pub fn number(self, name: &str, default: f32, [low, high]: [f32; 2]) -> f32 {
        let number = self.0.get(name).and_then(Value::as_f64).map_or(default, |number| number as f32);
        if number.is_finite() { number.clamp(low, high) } else { default }
    }

    /// A share, 0 ..= 1.
    pub fn share(self, name: &str, default: f32) -> f32 {
        self.number(name, default, [0.0, 1.0])
    }

    /// A color whose channels are 0 ..= `most`.
    pub fn color(self, name: &str, default: f32, most: f32) -> [f32; 3] {
        core::array::from_fn(|channel| {
            let number = self.0.get(name).and_then(|color| color.get(channel)).and_then(Value::as_f64);
            let number = number.map_or(default, |number| number as f32);
            if number.is_finite() { number.clamp(0.0, most) } else { default }
        })
    }

    /// A texture.
    pub fn texture(self, name: &str) -> Option<Used> {
        let value = self.0.get(name)?;
        let info: Info = from_value(value.clone()).ok()?;
        let scale = value.get("scale").and_then(Value::as_f64).unwrap_or(1.0) as f32;
        let scale = if scale.is_finite() { scale.clamp(-COLOR_LIMIT, COLOR_LIMIT) } else { 1.0 };
        Some(Used { index: info.index, texture_use: TextureUse::of(&info), scale })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn properties_have_defaults_and_ranges() {
        let value: Value = gltf_json::deserialize::from_str(
            r#"{ "a": 0.5, "b": 7, "c": [0.1, 2, "x"], "d": "no", "e": { "index": 3, "texCoord": 1, "scale": 0.25 } }"#,
        )
        .unwrap();
        let p = Properties(&value);
        assert_eq!(
            [p.share("a", 0.0), p.share("b", 0.0), p.share("d", 0.3), p.share("z", 0.2)],
            [0.5, 1.0, 0.3, 0.2]
        );
        assert_eq!(p.color("c", 1.0, 1.5), [0.1, 1.5, 1.0]);
        let used = p.texture("e").unwrap();
        assert_eq!((used.index.value(), used.scale), (3, 0.25));
        assert!(p.texture("a").is_none() && p.texture("z").is_none());
    }
}
