#pragma once
//
// The subcommands of the program `strak`, one source file each. Each function declares its command's options and what
// runs when it is called; the work is the library's.

#include <CLI/CLI.hpp>
#include <string>

namespace strak::cli {

void addInfo(CLI::App& program);
// `commandLine`, as it was typed, goes into the report.
void addFair(CLI::App& program, const std::string& commandLine);
void addCompare(CLI::App& program);
void addConvert(CLI::App& program);
void addRender(CLI::App& program);

}  // namespace strak::cli
