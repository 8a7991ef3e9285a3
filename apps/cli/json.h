#pragma once
//
// What all commands' JSON has in common.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "strak/exchange/model.h"

namespace strak::cli {

using Json = nlohmann::ordered_json;

// The start of every command's JSON: version, command (the whole line), inputs.
Json jsonHead(const std::string& command, const std::vector<std::string>& inputs);

Json jsonOf(const Audit& audit);

// One JSON object and a line end on stdout; names that are not UTF-8 are repaired.
void printJson(const Json& json);

}  // namespace strak::cli
