"""Fields: what a number is called, its unit, and its limits."""

from ._arguments import (
    listed_names as listed_names,
    listed_numbers as listed_numbers,
    refuse_complex as refuse_complex,
    refuse_options as refuse_options,
)
from ._computed import In as In, units_of as units_of
from ._counts import (
    FEWEST_TRACED as FEWEST_TRACED,
    Count as Count,
    CountOrTraced as CountOrTraced,
    as_count as as_count,
    at_least as at_least,
    plain as plain,
)
from ._declared import (
    Declared as Declared,
    declared as declared,
    members as members,
    module_classes as module_classes,
    values_of as values_of,
)
from ._fields import (
    Converted as Converted,
    Number as Number,
    Numbers as Numbers,
    OptionalNumber as OptionalNumber,
    OptionalNumbers as OptionalNumbers,
    Scalar as Scalar,
    as_optional_scalar as as_optional_scalar,
    as_scalar as as_scalar,
    choice as choice,
    driven as driven,
    number as number,
    numbers as numbers,
    optional_number as optional_number,
    optional_numbers as optional_numbers,
    part as part,
    registered_choice as registered_choice,
)
from ._limits import (
    ACUTE_ANGLE as ACUTE_ANGLE,
    ANY as ANY,
    COUNT as COUNT,
    DAMPING_RATIO as DAMPING_RATIO,
    INNER_SHARE as INNER_SHARE,
    MANY as MANY,
    NOT_NEGATIVE as NOT_NEGATIVE,
    NOT_ZERO as NOT_ZERO,
    OF_A_THREAD as OF_A_THREAD,
    POISSON_RATIO as POISSON_RATIO,
    POSITIVE as POSITIVE,
    RADIUS_RATIO as RADIUS_RATIO,
    ROLLER_NUMBER as ROLLER_NUMBER,
    ROLLERS as ROLLERS,
    SAMPLES as SAMPLES,
    SHAPES as SHAPES,
    SHARE as SHARE,
    SHARE_ABOVE_0 as SHARE_ABOVE_0,
    SLANT as SLANT,
    STARTS as STARTS,
    THREADS as THREADS,
    Limit as Limit,
    limit_of as limit_of,
)
from ._renamed import old_name as old_name, renamed_arguments as renamed_arguments
from ._within import (
    Contradiction as Contradiction,
    Limited as Limited,
    check_distances as check_distances,
    check_fields as check_fields,
    check_number as check_number,
    check_related as check_related,
    check_stage as check_stage,
)
