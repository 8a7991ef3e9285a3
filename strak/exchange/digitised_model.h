#pragma once
//
// A digitised curve (digitised.h) as an open file.

#include <filesystem>
#include <memory>
#include <string>

#include "strak/exchange/model.h"

namespace strak {

// One object of kind "digitised curve". It is written as splines to every other format, and to .dat, .csv and .txt as
// the file that was read with its points moved. Throws InvalidInput like parseDigitised.
std::unique_ptr<Model> digitisedModel(const std::string& text, const std::filesystem::path& path);

}  // namespace strak
