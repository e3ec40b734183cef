//! The mistakes that the tracer can make.

/// Defines `Mistake` and the list of all mistakes.
macro_rules! mistakes {
    ($($mistake:ident),* $(,)?) => {
        /// A mistake in a ray tracer.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Mistake { $($mistake),* }

        impl Mistake {
            pub const ALL: &[Self] = &[$(Self::$mistake),*];
        }
    };
}

mistakes! {
    // Rays of the camera. Pixel i is at i/(w - 1), or at i/w, instead of (i + 1/2)/w.
    PixelsOverWidthMinusOne,
    PixelCorners,
    // The half width of the screen: tan(angle), tan(angle / 4), or angle / 2, instead of tan(angle / 2).
    WholeAngle,
    QuarterOfAngle,
    AngleWithoutTangent,
    // Both sides of the picture span the angle or the size of the camera.
    SidesNotInProportion,
    ViewLarger,

    // The scene. Lists of objects are those of all groups.
    LastObjectMissing,
    FirstObjectMissing,
    LastTriangleMissing,
    LastLightMissing,
    // The next material, and the first one after the last.
    MaterialsOffByOne,
    MaterialsAllFirst,
    LightsDimmer,
    RadiusLarger,
    RotationsInRadians,
    RotationsReversed,
    OnlyInnermostTransform,

    // Hits.
    LastHitWins,
    FarHitOfSpheres,
    BackFacesCulled,
    TrianglesReversed,
    DistanceNotRescaled,
    // Of spheres, and of transformed objects.
    NormalsNotNormalised,
    // The cross product of edges. A transform normalises it.
    TriangleNormalsNotNormalised,

    // Diffuse light, with the cosine N.L.
    CosineNotClamped,
    CosineAbsolute,
    NoAmbient,
    LightsOverwritten,

    // Highlights.
    HighlightsUngated,
    HighlightsByReflection,
    // R = 2 (N.L) (N - L) instead of 2 (N.L) N - L.
    HighlightsByWrongReflection,
    ExponentQuartered,
    ExponentHalved,
    ExponentDoubled,
    ExponentTimesFour,
    // White where the highlight has a colour.
    HighlightsWhite,
    // White even where the highlight is black.
    HighlightsWithoutColor,
    HighlightsTimesDiffuse,
    // Times (n + 2) / 2 pi, or (n + 8) / 8 pi.
    HighlightsNormalisedByTwo,
    HighlightsNormalisedByEight,

    // Attenuation of point lights.
    AttenuationByDistance,
    AttenuationTwice,
    AttenuationReversed,

    // Shadows.
    NoShadows,
    ShadowsHalve,
    ShadowsOfFirstLight,
    // All lights are blocked if any is.
    ShadowsOfAnyLight,
    // Shadow rays start this far off the surface along its normal, and have no epsilon.
    ShadowBiasOfHundredth,
    ShadowBiasOfTenth,

    // Secondary rays, including shadow rays.
    EpsilonZero,
    EpsilonOfTenth,
    OneBounceMore,
    OneBounceFewer,
    // Of reflected and refracted rays that hit nothing.
    BackgroundBlack,

    // Reflection. The colour k is squared, doubled or subtracted, or the surface's own colour is multiplied by 1 - k.
    ReflectionSquared,
    ReflectionTwice,
    ReflectionSubtracted,
    ReflectionBlended,

    // Refraction, with the same mistakes and those of its direction.
    RefractionSquared,
    RefractionTwice,
    RefractionSubtracted,
    RefractionBlended,
    RefractionStraight,
    RefractionIndicesSwapped,
    // The ratio of the indices is the one of entering, also where the ray leaves.
    RefractionFromOutsideOnly,
    TotalReflectionMirrored,

    // Textures.
    TextureMatrixInverted,
    TextureMatrixMissing,
    OneOctaveFewer,
    // The curve t^2 (3 - 2 t) of Perlin's first noise.
    NoiseWithOldCurve,
    // The weight is the ring, not its square.
    WoodNotSquared,
    // The rings' radius is x^2 + z^2 without the root.
    WoodWithoutRoot,

    // Layers.
    DepthInverted,
    NormalsHalved,
    NormalsClamped,

    // Colours of the finished picture: c^(1/2), c^(1/2.2), c / (1 + c).
    GammaOfTwo,
    Gamma,
    ToneMapped,

    // Bytes of the finished picture.
    Rounded,
    Times256,
    Wrapped,
    RedAndBlueSwapped,
    UpsideDown,
    Mirrored,
    // Left black. The first row and the corner are at the bottom left.
    FirstRowMissing,
    LastRowMissing,
    CornerMissing,
    CornerBlockMissing,
}

impl Mistake {
    /// Returns the name in snake case.
    pub fn name(self) -> String {
        let mut name = String::new();
        for letter in format!("{self:?}").chars() {
            if letter.is_uppercase() && !name.is_empty() {
                name.push('_');
            }
            name.push(letter.to_ascii_lowercase());
        }
        name
    }
}

/// A set of mistakes.
#[derive(Clone, Copy, Debug)]
pub struct Mistakes([bool; Mistake::ALL.len()]);

impl Mistakes {
    pub fn new(mistakes: &[Mistake]) -> Self {
        let mut has = [false; Mistake::ALL.len()];
        mistakes.iter().for_each(|&mistake| has[mistake as usize] = true);
        Self(has)
    }

    #[inline(always)]
    pub fn has(&self, mistake: Mistake) -> bool {
        self.0[mistake as usize]
    }
}
