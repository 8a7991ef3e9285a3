// strak: makes B-spline curves, surfaces and volumes fair, and proves it.
//
// Exit codes: 0 done, 1 the work failed (disk full, folder missing), 2 the input or an option cannot be used. Errors
// are one sentence on stderr.

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>

#if __has_include(<malloc.h>)
#include <malloc.h>
#endif

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "strak/base/error.h"
#ifdef STRAK_HAS_CAD
#include "strak/exchange/cad.h"
#endif

namespace {

constexpr int kFailure = 1;
constexpr int kBadInput = 2;

int fail(int code, const std::string& sentence) {
  strak::cli::printError(sentence);
  return code;
}

// The command line as one would type it: words with other than plain characters in quotes.
std::string commandLineOf(int argc, char** argv) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=+.,:/@%";
  std::string line = "strak";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = !word.empty() && word.find_first_not_of(kPlain) == std::string::npos;
    line += plain ? " " + word : " '" + word + "'";
  }
  return line;
}

// The command that was named, for hints; the program itself if none was.
const CLI::App& namedCommand(const CLI::App& program) {
  const auto named = program.get_subcommands();
  return named.empty() ? program : *named.front();
}

int run(int argc, char** argv) {
  CLI::App program("Makes B-spline curves, surfaces and volumes fair within a certified tolerance.", "strak");
  program.set_version_flag("--version", std::string("strak ") + STRAK_VERSION, "Print the version and exit");
  program.set_help_all_flag("--help-all", "Help of all commands");
  program.require_subcommand(1);
  program.footer(
      "Example:\n  strak fair hood.step -o fair.step --tolerance 0.5 --report fair.html\n"
      "Each command explains itself: strak fair --help");
  const std::string commandLine = commandLineOf(argc, argv);
  strak::cli::addInfo(program, commandLine);
  strak::cli::addFair(program, commandLine);
  strak::cli::addFit(program, commandLine);
  strak::cli::addInspect(program, commandLine);
  strak::cli::addCompare(program, commandLine);
  strak::cli::addConvert(program, commandLine);
  strak::cli::addRender(program, commandLine);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    const auto& command = namedCommand(program);
    const std::string name = &command == &program ? "strak" : "strak " + command.get_name();
    return fail(kBadInput, std::string(error.what()) + " (see " + name + " --help)");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
#ifdef SIGXFSZ
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow further is a failed write, not a crash
#endif
#ifdef M_TRIM_THRESHOLD
  // What a block of points or a window of a factor took is taken again at once: kept, it need not be cleared by the
  // system every time (a fifth of the time of large runs).
  mallopt(M_MMAP_THRESHOLD, 1 << 28);
  mallopt(M_TRIM_THRESHOLD, 1 << 28);
#endif
#ifdef STRAK_HAS_CAD
  strak::enableCad();
#endif
  int code = 0;
  try {
    code = run(argc, argv);
  } catch (const strak::InvalidInput& error) {
    code = fail(kBadInput, error.what());
  } catch (const std::bad_alloc&) {
    code = fail(kFailure, "there is not enough memory for this: use a smaller net or fewer faces at once");
  } catch (const std::exception& error) {
    code = fail(kFailure, error.what());
  }
  if (std::fflush(stdout) != 0 && code == 0) {
    code = fail(kFailure, "cannot write to standard output: check where it goes");
  }
  return code;
}
