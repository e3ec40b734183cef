//! Scenes whose pixels are explained.

pub const GLASS: &str = "PerspectiveCamera { center 0 1 9 direction 0 -.1 -1 up 0 1 0 angle 30 }
Background { color .2 .3 .6 ambientLight .1 .1 .1 }
Lights { numLights 2
  DirectionalLight { direction -.3 -1 -.5 color .8 .8 .8 }
  PointLight { position 3 4 5 color .5 .4 .3 attenuation 1 .1 0 } }
Materials { numMaterials 3
  Material { diffuseColor .1 .1 .1 specularColor .9 .9 .9 exponent 30 reflectiveColor .3 .3 .3
             transparentColor .8 .7 .7 indexOfRefraction 1.5 }
  Material { diffuseColor 1 .5 .25 }
  Material { diffuseColor .2 .6 .2 reflectiveColor .5 .5 .5 } }
Group { numObjects 4
  MaterialIndex 0
  Sphere { center 0 0 0 radius 1 }
  MaterialIndex 2
  Transform { Translate 1.7 .4 -1 Scale 1 2 1
    Sphere { center 0 0 0 radius .5 } }
  MaterialIndex 1
  Plane { normal 0 1 0 offset -1 }
  MaterialIndex 2
  Box { min -2 -1 -1.5 max -1 0 -.5 }
}";

pub const BOARD: &str = "OrthographicCamera { center 0 0 5 direction 0 -.4 -1 up 0 1 0 size 6 }
Lights { numLights 1 DirectionalLight { direction -.4 -1 -.2 color 1 1 1 } }
Materials { numMaterials 3
  Material { diffuseColor .9 .1 .2 } Material { diffuseColor .2 .3 .9 specularColor .4 .4 .4 exponent 9 }
  Checkerboard { Transform { Scale .7 .7 .7 } materialIndex 0 materialIndex 1 } }
Group { numObjects 2 MaterialIndex 2
  Plane { normal 0 1 0 offset -1 }
  Sphere { center 0 0 0 radius 1 }
}";

pub const MESH: &str = "PerspectiveCamera { center 1 3 6 direction -.15 -.45 -1 up 0 1 0 angle 35 }
Lights { numLights 1 PointLight { position 2 5 3 color 1 1 1 } }
Materials { numMaterials 2 Material { diffuseColor .8 .7 .6 } Material { diffuseColor .3 .5 .3 } }
Group { numObjects 2
  MaterialIndex 1
  Triangle { vertex0 -6 -1 6 vertex1 6 -1 6 vertex2 0 -1 -9 }
  MaterialIndex 0
  Transform { YRotate 25
    TriangleMesh { obj_file m.obj } }
}";

pub const OBJ: &str = "v 0 1 0\nv 1 -1 1\nv -1 -1 1\nv -1 -1 -1\nv 1 -1 -1\n
f 1 3 2\nf 1 2 5\nf 1 5 4\nf 1 4 3\nf 2 3 4 5\n";

pub const MARBLE: &str = "PerspectiveCamera { center 0 0 8 direction 0 0 -1 up 0 1 0 angle 20 }
Background { color .5 .5 .5 ambientLight .2 .2 .2 }
Lights { numLights 1 DirectionalLight { direction 0 0 -1 color .9 .9 .9 } }
Materials { numMaterials 4
  Material { diffuseColor 1 1 1 } Material { diffuseColor .1 .2 .4 specularColor .5 .5 .5 exponent 20 }
  Marble { materialIndex 0 materialIndex 1 octaves 4 frequency 3 amplitude 4 }
  Wood { materialIndex 2 materialIndex 1 octaves 3 frequency 9 amplitude 2 } }
Group { numObjects 3
  MaterialIndex 2
  Sphere { center -.6 0 0 radius .8 }
  MaterialIndex 3
  Box { min .2 -.8 -1 max 1.2 .8 0 }
  Triangle { vertex0 -1 1.1 0 vertex1 1 1.1 0 vertex2 0 .9 -3 }
}";
