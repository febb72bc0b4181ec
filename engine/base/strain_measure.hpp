#pragma once
// Which strain the elements measure: the corotated one, or that of Green (St. Venant-Kirchhoff). See mechanics/strain.hpp.

namespace tetfront {

enum class StrainMeasure { corotated, green };

}  // namespace tetfront
