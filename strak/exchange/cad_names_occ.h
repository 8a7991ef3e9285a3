#pragma once
//
// The names that a CAD file gives to its faces and edges. Only for the *_occ.cpp files.

#include <TopoDS_TShape.hxx>
#include <map>
#include <string>

#include "strak/exchange/cad_file_occ.h"

namespace strak::cad {

// One that is all of its part goes by the part's name; names that Open CASCADE made up are left out.
std::map<const TopoDS_TShape*, std::string> namesOf(const CadFile& file);

}  // namespace strak::cad
