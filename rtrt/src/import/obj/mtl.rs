//! MTL: the materials of an OBJ file.

use super::text::{lines, number, numbers};
use rtrt_core::layout::COLOR_LIMIT;
use std::collections::BTreeSet;

/// A material of an MTL file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MtlMaterial {
    pub name: String,
    /// `Kd`.
    pub diffuse: Option<[f32; 3]>,
    /// `Ks`.
    pub specular: [f32; 3],
    /// `Ns`, at least 1.
    pub shininess: f32,
    /// `Ke`.
    pub emission: [f32; 3],
    /// `d`, or 1 − `Tr`: 0 ..= 1.
    pub alpha: f32,
    /// `Pr`, 0 ..= 1.
    pub roughness: Option<f32>,
    /// `Pm`, 0 ..= 1.
    pub metallic: Option<f32>,
    /// `Pc`: the share that a clear coat covers, 0 ..= 1.
    pub coat: f32,
    /// `Pcr`, 0 ..= 1.
    pub coat_roughness: f32,
    /// `Ps`: the brightness of a sheen, 0 ..= 1.
    pub sheen: f32,
    pub maps: Maps,
    /// Properties that the renderer does not have.
    pub not_drawn: BTreeSet<&'static str>,
}

/// The textures of a material.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Maps {
    /// `map_Kd`.
    pub diffuse: Option<MapReference>,
    /// `map_d`.
    pub alpha: Option<MapReference>,
    /// `map_Ke`.
    pub emission: Option<MapReference>,
    /// `map_Pr`.
    pub roughness: Option<MapReference>,
    /// `map_Pm`.
    pub metallic: Option<MapReference>,
    /// `norm`: a normal map.
    pub normal: Option<MapReference>,
    /// `map_Bump` or `bump`: heights, or, as many exporters write it, a normal map.
    pub bump: Option<MapReference>,
}

/// A reference to a texture, with its options.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MapReference {
    pub file: String,
    /// `-o`, `v` pointing up.
    pub offset: [f32; 2],
    /// `-s`.
    pub scale: [f32; 2],
    /// `-clamp on`: the edge of the texture continues outside of it.
    pub clamp: bool,
    /// `-bm`.
    pub strength: f32,
    /// `-imfchan`: which channel a scalar is read from.
    pub channel: Option<char>,
}

/// The keys of properties that the renderer does not have, in lower case, and their names in warnings.
const NOT_DRAWN: [(&str, &str); 14] = [
    ("aniso", "aniso of MTL"),
    ("anisor", "anisor of MTL"),
    ("decal", "decal of MTL"),
    ("disp", "disp of MTL"),
    ("map_disp", "disp of MTL"),
    ("map_ks", "map_Ks of MTL"),
    ("map_ns", "map_Ns of MTL"),
    ("map_pc", "map_Pc of MTL"),
    ("map_pcr", "map_Pcr of MTL"),
    ("map_ps", "map_Ps of MTL"),
    ("map_refl", "refl of MTL"),
    ("map_tr", "map_Tr of MTL"),
    ("refl", "refl of MTL"),
    ("tf", "Tf of MTL"),
];

impl MtlMaterial {
    fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            diffuse: None,
            specular: [0.0; 3],
            shininess: 1.0,
            emission: [0.0; 3],
            alpha: 1.0,
            roughness: None,
            metallic: None,
            coat: 0.0,
            coat_roughness: 0.0,
            sheen: 0.0,
            maps: Maps::default(),
            not_drawn: BTreeSet::new(),
        }
    }

    /// Reads a property other than transparency. `key` is in lower case.
    fn set(&mut self, key: &str, rest: &str) {
        let maps = &mut self.maps;
        match key {
            "kd" => self.diffuse = color(rest).or(self.diffuse),
            "ks" => self.specular = color(rest).unwrap_or(self.specular),
            "ke" => self.emission = color(rest).unwrap_or(self.emission),
            "ns" => {
                let shininess = numbers(rest).map_or(1.0, |n| n.values[0]);
                self.shininess = if shininess >= 1.0 { shininess.min(8192.0) } else { 1.0 };
            }
            "pr" => self.roughness = share(rest).or(self.roughness),
            "pm" => self.metallic = share(rest).or(self.metallic),
            "pc" => self.coat = share(rest).unwrap_or(0.0),
            "pcr" => self.coat_roughness = share(rest).unwrap_or(0.0),
            "ps" => self.sheen = share(rest).unwrap_or(0.0),
            "map_kd" => maps.diffuse = map(rest, &mut self.not_drawn),
            "map_d" => maps.alpha = map(rest, &mut self.not_drawn),
            "map_ke" => maps.emission = map(rest, &mut self.not_drawn),
            "map_pr" => maps.roughness = map(rest, &mut self.not_drawn),
            "map_pm" => maps.metallic = map(rest, &mut self.not_drawn),
            "norm" | "map_kn" => maps.normal = map(rest, &mut self.not_drawn),
            "map_bump" | "bump" => maps.bump = map(rest, &mut self.not_drawn),
            _ => {
                // Exporters write these numbers for materials without the property, too.
                let without = if key == "tf" { 1.0 } else { 0.0 };
                let has_effect =
                    numbers(rest).map_or(true, |n| n.values[..n.count].iter().any(|n| *n != without));
                let known = NOT_DRAWN.iter().find(|(known, _)| *known == key);
                self.not_drawn.extend(known.filter(|_| has_effect).map(|(_, name)| name));
            }
        }
    }
}

/// The materials in the file. Unknown keys are ignored, and so are values that cannot be read.
pub(super) fn parse(bytes: &[u8]) -> Vec<MtlMaterial> {
    let mut materials: Vec<MtlMaterial> = Vec::new();
    // `d` has precedence over `Tr`.
    let mut has_d = false;
    for (_, line) in lines(bytes) {
        let (key, rest) = line.split_once(char::is_whitespace).unwrap_or((&line, ""));
        let rest = rest.trim();
        if key == "newmtl" {
            has_d = false;
            materials.push(MtlMaterial::new(rest));
            continue;
        }
        let Some(material) = materials.last_mut() else { continue };
        match key.to_ascii_lowercase().as_str() {
            "d" => {
                has_d = true;
                material.alpha = share(rest).unwrap_or(1.0);
            }
            // Some programs write `Tr 1` for an opaque material.
            "tr" if !has_d => material.alpha = share(rest).filter(|&tr| tr < 1.0).map_or(1.0, |tr| 1.0 - tr),
            key => material.set(key, rest),
        }
    }
    materials
}

/// A single number, clamped to 0 ..= 1.
fn share(rest: &str) -> Option<f32> {
    let share = numbers(rest).ok().filter(|n| n.count == 1)?.values[0];
    share.is_finite().then(|| share.clamp(0.0, 1.0))
}

/// A color of three numbers, or of one for gray; none for `spectral` and `xyz`.
fn color(rest: &str) -> Option<[f32; 3]> {
    let n = numbers(rest).ok()?;
    let values = if n.count == 1 { [n.values[0]; 3] } else { n.first() };
    let is_color = (n.count == 1 || n.count == 3) && values.iter().all(|v| v.is_finite());
    is_color.then(|| values.map(|v| v.clamp(0.0, COLOR_LIMIT)))
}

/// A texture's options and, behind them, its file. Options without an equivalent are added to `not_drawn`.
fn map(mut rest: &str, not_drawn: &mut BTreeSet<&'static str>) -> Option<MapReference> {
    let mut map = MapReference {
        file: String::new(),
        offset: [0.0; 2],
        scale: [1.0; 2],
        clamp: false,
        strength: 1.0,
        channel: None,
    };
    while let Some((option, after)) = rest.strip_prefix('-').and_then(|r| r.split_once(char::is_whitespace)) {
        // `-o`, `-s` and `-t` have one to three numbers, `-mm` has two, all others have one word.
        let (least, most) = match option {
            "o" | "s" | "t" => (1, 3),
            "mm" => (2, 2),
            _ => (1, 1),
        };
        let (mut words, mut remaining) = (Vec::new(), after.trim_start());
        for place in 0..most {
            let (word, after) = remaining.split_once(char::is_whitespace).unwrap_or((remaining, ""));
            if place >= least && number(word).is_none() {
                break;
            }
            words.push(word);
            remaining = after.trim_start();
        }
        set_option(&mut map, option, &words, not_drawn);
        rest = remaining;
    }
    map.file = rest.to_owned();
    (!rest.is_empty()).then_some(map)
}

/// Reads an option. Numbers that are missing or not finite keep their defaults.
fn set_option(map: &mut MapReference, option: &str, words: &[&str], not_drawn: &mut BTreeSet<&'static str>) {
    let number = |place: usize| words.get(place).and_then(|word| number(word)).filter(|n| n.is_finite());
    match option {
        "o" => map.offset = [0, 1].map(|axis| number(axis).unwrap_or(0.0)),
        "s" => map.scale = [0, 1].map(|axis| number(axis).unwrap_or(1.0)),
        "bm" => map.strength = number(0).unwrap_or(1.0).clamp(-COLOR_LIMIT, COLOR_LIMIT),
        "clamp" => map.clamp = words.contains(&"on"),
        "imfchan" => map.channel = words.first().and_then(|word| word.chars().next()),
        "mm" if (number(0), number(1)) != (Some(0.0), Some(1.0)) => {
            not_drawn.insert("the option -mm of textures of MTL");
        }
        "t" if words.iter().any(|word| self::number(word) != Some(0.0)) => {
            not_drawn.insert("the option -t of textures of MTL");
        }
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(rest: &str) -> Option<MapReference> {
        map(rest, &mut BTreeSet::new())
    }

    #[test]
    fn a_texture_follows_its_options() {
        let name = |rest| texture(rest).unwrap().file;
        assert_eq!(name("a b.png"), "a b.png");
        assert_eq!(name("-s 2 2 1 -o 0.5 wood.jpg"), "wood.jpg");
        assert_eq!(name("-bm 0.5 -blendu on -mm 0 1 7 up.png"), "7 up.png");
        assert_eq!(texture(""), None);
        let map = texture("-clamp on -s 2 3 -o 0.5 -bm 0.25 -imfchan g x.png").unwrap();
        assert_eq!((map.clamp, map.scale, map.offset), (true, [2.0, 3.0], [0.5, 0.0]));
        assert_eq!((map.strength, map.channel), (0.25, Some('g')));
    }

    #[test]
    fn d_is_alpha_and_tr_its_complement() {
        let alpha = |text: &str| parse(format!("newmtl a\n{text}").as_bytes())[0].alpha;
        assert_eq!([alpha("d 0.25"), alpha("Tr 0.25"), alpha("d 0.5\nTr 0.9")], [0.25, 0.75, 0.5]);
        assert_eq!([alpha("Tr 1"), alpha("d nan"), alpha("d 7"), alpha("d")], [1.0; 4]);
    }

    #[test]
    fn broken_lines_keep_the_defaults() {
        let materials = parse(b"Kd 1 1 1\nnewmtl a b\nKd spectral x\nKs nan 0 0\nNs -3\nKe 0.5\nPr x\n");
        assert_eq!(materials.len(), 1);
        assert_eq!((materials[0].name.as_str(), materials[0].diffuse), ("a b", None));
        assert_eq!((materials[0].shininess, materials[0].emission), (1.0, [0.5; 3]));
        assert_eq!((materials[0].roughness, materials[0].metallic), (None, None));
    }

    #[test]
    fn properties_without_an_equivalent_are_named_where_they_have_an_effect() {
        let names = |text: &str| parse(format!("newmtl a\n{text}").as_bytes())[0].not_drawn.clone();
        assert!(names("Tf 1 1 1\nPs 0\naniso 0\nillum 4\nNi 1.45\nKa 1 1 1\nmap_Ka a.png").is_empty());
        let named = names("Tf 0.5 1 1\naniso 0.3\nmap_Ks a.png\nmap_Kd -t 1 b.png");
        let expected = ["Tf of MTL", "aniso of MTL", "map_Ks of MTL", "the option -t of textures of MTL"];
        assert_eq!(named, BTreeSet::from(expected));
    }
}
