//! Changes of materials, as `--material` takes them: `3:color=0.8,0.1,0.1:roughness=0.4`.

use super::parse::tone;
use glam::Vec3;
use rtrt_core::scene::{Material, MaterialIndex, Scene};
use std::fmt;
use std::str::FromStr;

/// Numbers of a material that replace those of the file.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Repaint {
    /// The number of the material.
    pub number: u32,
    /// Linear.
    pub color: Option<Vec3>,
    pub metallic: Option<f32>,
    pub roughness: Option<f32>,
    pub alpha: Option<f32>,
    pub emission: Option<Vec3>,
    pub transmission: Option<f32>,
}

impl Repaint {
    /// The material with these numbers.
    pub fn applied(&self, material: &Material) -> Material {
        let mut next = *material;
        next.base_color = self.color.unwrap_or(next.base_color);
        next.metallic = self.metallic.unwrap_or(next.metallic);
        next.roughness = self.roughness.unwrap_or(next.roughness);
        next.alpha = self.alpha.unwrap_or(next.alpha);
        next.emission = self.emission.unwrap_or(next.emission);
        next.transmission = self.transmission.unwrap_or(next.transmission);
        next
    }

    /// What changes one material into another; of no use for other numbers than those that can be given.
    #[cfg(feature = "viewer")]
    pub fn between(number: u32, before: &Material, after: &Material) -> Self {
        fn changed<T: PartialEq>(before: T, after: T) -> Option<T> {
            (before != after).then_some(after)
        }
        Self {
            number,
            color: changed(before.base_color, after.base_color),
            metallic: changed(before.metallic, after.metallic),
            roughness: changed(before.roughness, after.roughness),
            alpha: changed(before.alpha, after.alpha),
            emission: changed(before.emission, after.emission),
            transmission: changed(before.transmission, after.transmission),
        }
    }
}

/// The index of the material with a number; none if no object has it.
pub fn material(scene: &Scene, number: u32) -> Option<MaterialIndex> {
    let object = scene.instances().iter().position(|instance| instance.material == number)?;
    scene.material_of(scene.instance_index(object as u32)?)
}

impl fmt::Display for Repaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { number, color, metallic, roughness, alpha, emission, transmission } = self;
        write!(f, "{number}")?;
        for (name, color) in [("color", color), ("emission", emission)] {
            if let Some(Vec3 { x, y, z }) = color {
                write!(f, ":{name}={x},{y},{z}")?;
            }
        }
        let numbers = [
            ("metallic", metallic),
            ("roughness", roughness),
            ("alpha", alpha),
            ("transmission", transmission),
        ];
        for (name, number) in numbers {
            if let Some(number) = number {
                write!(f, ":{name}={number}")?;
            }
        }
        Ok(())
    }
}

impl FromStr for Repaint {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut parts = text.split(':');
        let number = parts.next().and_then(|number| number.parse().ok());
        let mut repaint = Self { number: number.ok_or("not a number of a material")?, ..Self::default() };
        let mut count = 0;
        for part in parts {
            count += 1;
            let (name, value) = part.split_once('=').ok_or("a change is KEY=VALUE")?;
            let share = || {
                let number = value.parse().ok().filter(|number| (0.0..=1.0).contains(number));
                number.ok_or(format!("{name} is not a number within 0 and 1"))
            };
            match name {
                "color" => repaint.color = Some(tone(value)?),
                "emission" => repaint.emission = Some(tone(value)?),
                "metallic" => repaint.metallic = Some(share()?),
                "roughness" => repaint.roughness = Some(share()?),
                "alpha" => repaint.alpha = Some(share()?),
                "transmission" => repaint.transmission = Some(share()?),
                _ => return Err(format!("no such key: {name}")),
            }
        }
        if count == 0 {
            return Err("nothing is changed: KEY=VALUE is missing".into());
        }
        Ok(repaint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_printed_is_read_as_the_same() {
        let plain = Material::default();
        let mut other = plain;
        let mut all = Vec::new();
        other.base_color = Vec3::new(0.1, 1e-9, 3.3);
        all.push(other);
        (other.metallic, other.roughness) = (0.25, 1.0 / 3.0);
        all.push(other);
        (other.alpha, other.transmission, other.emission) = (0.5, 0.7, Vec3::new(9.0, 0.0, 1e9));
        all.push(other);
        for after in all {
            let repaint = Repaint::between(7, &plain, &after);
            assert_eq!(repaint.to_string().parse(), Ok(repaint));
            assert_eq!(repaint.applied(&plain), after);
        }
    }

    #[test]
    fn bad_changes_are_refused() {
        for bad in
            ["", "x:alpha=1", "1", "1:", "1:alpha", "1:alpha=2", "1:alpha=nan", "1:color=1,2", "1:shine=1"]
        {
            assert!(bad.parse::<Repaint>().is_err(), "{bad}");
        }
    }
}
