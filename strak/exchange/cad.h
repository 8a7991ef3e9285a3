#pragma once
//
// STEP, IGES and BREP through Open CASCADE: the library strak::cad.

namespace strak {

// Makes readModel and Model::write understand STEP, IGES and BREP. Call it once at the start of a program that is
// linked with strak::cad (which defines STRAK_HAS_CAD for its users); calling it again does nothing.
void enableCad();

}  // namespace strak
