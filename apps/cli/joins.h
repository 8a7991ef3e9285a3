#pragma once
//
// How the faces of a file join, for the terminal and for reports.

#include <string>
#include <vector>

#include "strak/exchange/model.h"
#include "strak/report/fair_report.h"

namespace strak::cli {

// The edges of the model as it was (the entries' splines before) and as it is now.
std::vector<EdgeJoin> joinsOf(const Model& model, const std::vector<FairedObject>& before);

// The edges of the model as it is; before and after are the same.
std::vector<EdgeJoin> joinsOf(const Model& model);

// One line, with an end of line; empty without joins.
std::string joinsText(const std::vector<EdgeJoin>& joins, const std::string& unit);      // largest, before -> after
std::string joinCountText(const std::vector<EdgeJoin>& joins, const std::string& unit);  // how many of which kind

}  // namespace strak::cli
