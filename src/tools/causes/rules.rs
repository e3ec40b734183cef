//! The rules that a student's tracer breaks.

/// A broken rule. The table of mistakes describes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    AmbientFromAbove,
    AmbientWithoutDiffuse,
    AttenuationTwice,
    BackFacesCulled,
    BackgroundForCameraOnly,
    CheckerboardCut,
    CosineAbsolute,
    DepthAlongAxis,
    DepthInverted,
    DiffuseAbsolute,
    DiffuseNotClamped,
    DiffuseOverPi,
    DirectionsNotNormalised,
    FarHit,
    FirstHit,
    FrontFacesCulled,
    GlassWithoutShadows,
    HalfWayNotNormalised,
    HighlightsByReflection,
    HighlightsByWrongReflection,
    HighlightsNormalisedBlinn,
    HighlightsNormalisedPhong,
    HighlightsOnlyWhereLit,
    HighlightsTimesCosine,
    HighlightsTimesDiffuse,
    HighlightsUngated,
    IndexNotInverted,
    LastHit,
    LightsAndAmbientOverwritten,
    LightsClamped,
    LightsOverwritten,
    NoEpsilon,
    NoEpsilonOfSecondary,
    NoEpsilonOfShadows,
    NoiseHalved,
    NoiseSmoothStep,
    NormalFlippedInReflection,
    NormalNotFlippedInRefraction,
    NormalsByInverse,
    NormalsByMatrix,
    NormalsClamped,
    NormalsFlipped,
    NormalsNeverNormalised,
    NormalsNotFlipped,
    NormalsNotNormalised,
    NormalsOfObjectSpace,
    NormalsShifted,
    PointDirectionsNotNormalised,
    RaysClamped,
    ReflectionBlended,
    ReflectionFromBelow,
    ReflectionReversed,
    ReflectionWithoutColor,
    RefractionBlended,
    RefractionWithoutColor,
    SamplesClamped,
    SchlickSwapped,
    ShadowBiasHundredth,
    ShadowBiasTenth,
    ShadowBiasThousandth,
    ShadowRaysHalved,
    ShadowsBlack,
    ShadowsFromBehindLight,
    ShadowsHalve,
    ShadowsOfAnyLight,
    ShadowsOfFirstLight,
    SphereNormalsInward,
    SphereNormalsNotNormalised,
    TNotRescaled,
    TotalReflectionAdded,
    TotalReflectionDropped,
    TotalReflectionStraight,
    TriangleNormalsNotNormalised,
    WindingReversed,
    WoodNotSquared,
    WoodRootMissing,
}

/// A set of broken rules.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rules(u128);

impl Rules {
    pub fn add(&mut self, rule: Rule) {
        self.0 |= 1 << rule as u32;
    }

    pub fn has(self, rule: Rule) -> bool {
        self.0 >> rule as u32 & 1 != 0
    }

    /// Returns true if it has any of these rules.
    pub fn has_any(self, rules: &[Rule]) -> bool {
        rules.iter().any(|&rule| self.has(rule))
    }

    pub fn is_empty(self) -> bool {
        self.0 == 0
    }
}
