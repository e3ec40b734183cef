//! The mistakes that the tracer can make.

/// Defines `Mistake` and the list of all mistakes.
macro_rules! mistakes {
    ($($mistake:ident)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Mistake { $($mistake),* }

        impl Mistake {
            pub const ALL: &[Self] = &[$(Self::$mistake),*];
        }
    };
}

mistakes! {
    // Camera. Pixel i is at i/(w - 1) or i/w instead of (i + 1/2)/w. Half the screen is tan(angle), tan(angle/4) or
    // angle/2 instead of tan(angle/2). `SidesNotInProportion`: the camera's angle or size spans both sides.
    PixelsOverWidthMinusOne PixelCorners WholeAngle QuarterOfAngle AngleWithoutTangent SidesNotInProportion ViewLarger

    // Scene. Objects are missing from every group, triangles from every mesh. `MaterialsOffByOne`: the next material,
    // or the first one for the last.
    FirstObjectMissing LastObjectMissing LastTriangleMissing LastLightMissing MaterialsOffByOne MaterialsAllFirst
    LightsDimmer RadiusLarger RotationsInRadians RotationsReversed OnlyInnermostTransform

    // Hits. `NormalsNotNormalised` is about spheres and transformed objects. The other one is about the cross product
    // of edges, which is normalised if there is a transform.
    LastHitWins FarHitOfSpheres BackFacesCulled TrianglesReversed DistanceNotRescaled NormalsNotNormalised
    TriangleNormalsNotNormalised

    // Diffuse light. The cosine is N.L.
    CosineNotClamped CosineAbsolute NoAmbient LightsOverwritten

    // Highlights. R is 2 (N.L) N - L, or wrongly 2 (N.L) (N - L). `HighlightsWhite`: where their colour is not black.
    // `HighlightsWithoutColor`: everywhere. Factors: (n + 2) / 2 pi and (n + 8) / 8 pi.
    HighlightsUngated HighlightsByReflection HighlightsByWrongReflection ExponentQuartered ExponentHalved
    ExponentDoubled ExponentTimesFour HighlightsWhite HighlightsWithoutColor HighlightsTimesDiffuse
    HighlightsNormalisedByTwo HighlightsNormalisedByEight

    // Attenuation of point lights. `AttenuationByDistance`: the last coefficient times d instead of d^2.
    AttenuationByDistance AttenuationTwice AttenuationReversed

    // Shadows. `ShadowsOfAnyLight`: all lights are blocked if one is. With a bias, shadow rays start this far off the
    // surface, on the side of the viewer, and have no epsilon.
    NoShadows ShadowsHalve ShadowsOfFirstLight ShadowsOfAnyLight ShadowBiasOfHundredth ShadowBiasOfTenth

    // Secondary rays. The epsilon is also that of shadow rays. `BackgroundBlack`: where such rays hit nothing.
    EpsilonZero EpsilonOfTenth OneBounceMore OneBounceFewer BackgroundBlack

    // Reflection and refraction by a colour k. It is squared, doubled or subtracted, or the local colour is multiplied
    // by 1 - k where the ray is traced. `RefractionFromOutsideOnly`: the ratio of indices is always that of entering.
    ReflectionSquared ReflectionTwice ReflectionSubtracted ReflectionBlended
    RefractionSquared RefractionTwice RefractionSubtracted RefractionBlended
    RefractionStraight RefractionIndicesSwapped RefractionFromOutsideOnly TotalReflectionMirrored

    // Textures. `NoiseWithOldCurve`: t^2 (3 - 2t). The weight of wood is the square of a ring at sqrt(x^2 + z^2).
    TextureMatrixInverted TextureMatrixMissing OneOctaveFewer NoiseWithOldCurve WoodNotSquared WoodWithoutRoot

    // Layers, colours, and bytes. `NormalsHalved`: (N + 1) / 2 where a surface is hit. `ToneMapped`: c / (1 + c).
    DepthInverted NormalsHalved NormalsClamped GammaOfTwo Gamma ToneMapped
    Rounded Times256 Wrapped RedAndBlueSwapped UpsideDown Mirrored

    // Pixels left black. The first row is the lowest, the corner is the lower left one, the block has 5 x 5 pixels.
    FirstRowMissing LastRowMissing CornerMissing CornerBlockMissing
}

/// A set of mistakes.
#[derive(Clone, Copy)]
pub struct Mistakes([bool; Mistake::ALL.len()]);

impl Mistakes {
    pub fn new(mistakes: &[Mistake]) -> Self {
        Self(std::array::from_fn(|index| mistakes.contains(&Mistake::ALL[index])))
    }

    #[inline(always)]
    pub fn has(&self, mistake: Mistake) -> bool {
        self.0[mistake as usize]
    }

    /// Returns the first value whose mistake is made, or else the right one.
    pub fn pick<T, const N: usize>(&self, right: T, wrong: [(Mistake, T); N]) -> T {
        wrong.into_iter().find(|(mistake, _)| self.has(*mistake)).map_or(right, |(_, value)| value)
    }
}
