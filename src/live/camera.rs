//! The camera as the page knows it, and as a block of scene text.

use crate::scene::Camera;
use crate::scene::model::Screen;
use glam::DVec3;
use serde_json::{Value, json};

/// Returns what the page needs to move a camera, whose view is spread over the pixels in this way.
pub fn camera_values(camera: &Camera, screen: Screen) -> Value {
    let (is_stretched, up_as_written) = match screen {
        Screen::LongerSide => (false, false),
        Screen::BothSides { up_as_written } => (true, up_as_written),
    };
    match *camera {
        Camera::Orthographic { center, direction, up, size } => {
            json!({ "kind": "orthographic", "center": center, "direction": direction, "up": up, "size": size })
        }
        Camera::Perspective { center, direction, up, angle } => json!({
            "kind": "perspective", "center": center, "direction": direction, "up": up, "angle": angle,
            "is_stretched": is_stretched, "up_as_written": up_as_written,
        }),
    }
}

/// Returns the camera's block of scene text, from which the same camera is read: all digits of its numbers are there.
pub fn camera_block(camera: &Camera) -> String {
    let vector = |DVec3 { x, y, z }: DVec3| format!("{x} {y} {z}");
    let view = |center, direction, up| {
        format!("    center {}\n    direction {}\n    up {}", vector(center), vector(direction), vector(up))
    };
    match *camera {
        Camera::Orthographic { center, direction, up, size } => {
            format!("OrthographicCamera {{\n{}\n    size {size}\n}}\n", view(center, direction, up))
        }
        Camera::Perspective { center, direction, up, angle } => {
            format!("PerspectiveCamera {{\n{}\n    angle {angle}\n}}\n", view(center, direction, up))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse_camera;

    #[test]
    fn the_same_camera_is_read_from_its_block() {
        let center = DVec3::new(0.1 + 0.2, -1e-300, 1e9 / 7.0);
        let (direction, up) = (DVec3::new(1e100, 0.0, -1.0 / 3.0), DVec3::new(0.0, 1.0, 5e-324));
        for camera in [
            Camera::Orthographic { center, direction, up, size: 1.0 / 7.0 },
            Camera::Perspective { center, direction, up, angle: 30.000000000000004 },
        ] {
            assert_eq!(parse_camera(&camera_block(&camera)).unwrap(), camera);
        }
    }
}
