#pragma once
//
// The subcommands of the program `strak`, one source file each. Each function declares its command's options and what
// runs when it is called; the work is the library's. `commandLine`, as it was typed, goes into reports and JSON.

#include <CLI/CLI.hpp>
#include <string>

namespace strak::cli {

void addInfo(CLI::App& program, const std::string& commandLine);
void addFair(CLI::App& program, const std::string& commandLine);
void addFit(CLI::App& program, const std::string& commandLine);
void addInspect(CLI::App& program, const std::string& commandLine);
void addCompare(CLI::App& program, const std::string& commandLine);
void addConvert(CLI::App& program, const std::string& commandLine);
void addRender(CLI::App& program, const std::string& commandLine);

}  // namespace strak::cli
