//! Scenes of the project with their command lines, on which mistakes are tried.

use raytracer::cli::{self, Command, Options};
use raytracer::picture::Picture;
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::render::{Layer, Request};
use raytracer::scene::load::LoadedScene;
use std::ffi::OsString;
use std::path::Path;

/// A command line without the program's name. The picture in question is its only output.
pub struct Case {
    pub name: &'static str,
    pub flags: &'static str,
}

/// A scene with its options.
pub struct Opened {
    pub scene: LoadedScene,
    pub options: Options,
    pub layer: Layer,
}

#[rustfmt::skip]
pub const CASES: &[Case] = &[
    Case { name: "spheres", flags: "-input scene3_09_exponent_variations.txt -size 200 200" },
    Case { name: "transforms", flags: "-input scene6_10_nested_transformations.txt -size 200 160" },
    Case { name: "triangles", flags: "-input scene2_07_sphere_triangles.txt -size 200 200 -shade_back" },
    Case { name: "mesh", flags: "-input scene6_04_bunny_mesh_200.txt -size 200 200 -shadows" },
    Case { name: "checkerboard", flags: "-input scene6_13_checkerboard.txt -size 200 200 -shadows" },
    Case { name: "wood", flags: "-input scene6_16_wood_cubes.txt -size 200 200" },
    Case { name: "mirrors",
        flags: "-input scene4_04_reflective_sphere.txt -size 200 200 -shadows -bounces 3 -weight 0.01" },
    Case { name: "glass",
        flags: "-input scene6_14_glass_sphere.txt -size 200 200 -shadows -shade_back -bounces 5 -weight 0.01" },
    Case { name: "bars",
        flags: "-input scene4_05_transparent_bar.txt -size 200 200 -shadows -shade_back -bounces 5 -weight 0.01" },
    Case { name: "point_light",
        flags: "-input scene4_13_point_light_circle_d2_attenuation.txt -size 200 200 -shadows" },
    Case { name: "colored_shadows", flags: "-input scene4_02_colored_shadows.txt -size 200 200 -shadows" },
    Case { name: "depth",
        flags: "-input scene2_05_inside_sphere.txt -size 200 200 -shade_back -depth 9 11 depth.tga" },
    Case { name: "normals",
        flags: "-input scene2_13_rotated_squashed_sphere.txt -size 200 200 -normals normals.tga" },
];

impl Opened {
    /// Reads the scene of a command line. Its path is relative to a folder.
    pub fn new(folder: &Path, flags: &str) -> Self {
        let (mut words, mut last) = (vec![OsString::from("raytracer")], "");
        for word in flags.split_whitespace() {
            words.push(if last == "-input" { folder.join(word).into() } else { word.into() });
            last = word;
        }
        let Ok(Command::Render(options)) = cli::parse(words) else { panic!("{flags} renders nothing") };
        let scene = options.load_scene().unwrap();
        let options = options.in_edition(scene.choice.edition);
        let layer = options.outputs.first().map_or(Layer::Color, |output| output.layer);
        Self { scene, options, layer }
    }

    /// Renders the picture by this program.
    pub fn render(&self) -> Picture {
        let renderer = Renderer::new(self.scene.clone(), Meshes::Moved).unwrap();
        let request = Request { layers: vec![self.layer], ..self.options.request() };
        renderer.prepare(&request).unwrap().render(&request).unwrap()[0].to_picture()
    }
}

impl Case {
    pub fn open(&self) -> Opened {
        Opened::new(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"), self.flags)
    }
}
