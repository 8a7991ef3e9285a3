// Ctrl-C and the progress bar: what a person at a terminal meets.

#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "tests/cli/program.h"

namespace strak::test {
namespace {

class Interrupt : public Program {
 protected:
  // Starts a run that takes far longer than the test: local steps on a big net.
  pid_t startLongRun() {
    input_ = wavySurface(3, 120, 120, 0.05);
    write("in.g2", g2(input_));
    return start(
        {"fair", path("in.g2"), "-o", path("out.g2"), "--method", "local", "--gap", "1e-15", "--tolerance", "5"});
  }

  Surface input_;
};

TEST_F(Interrupt, CtrlCKeepsTheBestSoFar) {
  const pid_t process = startLongRun();
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));
  ASSERT_EQ(::kill(process, SIGINT), 0);
  const Outcome outcome = finish(process);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("interrupted"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.out.find("cancelled"), std::string::npos) << outcome.out;
  const Surface output = readSurface(file("out.g2"));
  EXPECT_EQ(output.knots(), input_.knots());
  EXPECT_NE(output.net(), input_.net());
}

TEST_F(Interrupt, ASecondCtrlCEndsAtOnceAndWritesNothing) {
  // On a busy machine the second one may come when the best net has been written already: then once more.
  for (int attempt = 0; attempt < 5; ++attempt) {
    const pid_t process = startLongRun();
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    ASSERT_EQ(::kill(process, SIGSTOP), 0);
    ASSERT_EQ(::kill(process, SIGINT), 0);
    ASSERT_EQ(::kill(process, SIGCONT), 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ::kill(process, SIGINT);
    const Outcome outcome = finish(process);
    if (outcome.code == 0) {
      std::filesystem::remove(file("out.g2"));
      continue;
    }
    EXPECT_EQ(outcome.code, 128 + SIGINT) << outcome.out;
    EXPECT_FALSE(std::filesystem::exists(file("out.g2")));
    return;
  }
  FAIL() << "five times the first Ctrl-C had done its work before the second one came";
}

TEST_F(Interrupt, ATerminalSeesAProgressBarThatGoesAway) {
  write("in.g2", g2(wavySurface(3, 60, 60)));
  const std::string program = STRAK_PROGRAM;
  const std::string input = path("in.g2");
  const std::string output = path("out.g2");
  int terminal = -1;
  const pid_t process = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(process, 0);
  if (process == 0) {
    ::execl(program.c_str(), program.c_str(), "fair", input.c_str(), "-o", output.c_str(), "--tolerance", "0.01",
            static_cast<char*>(nullptr));
    ::_exit(127);
  }
  std::string seen;
  char buffer[4096];
  for (ssize_t count = 0; (count = ::read(terminal, buffer, sizeof buffer)) > 0;) {
    seen.append(buffer, static_cast<std::size_t>(count));
  }
  int status = 0;
  ::waitpid(process, &status, 0);
  ::close(terminal);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  const auto bar = seen.find(" %  ");
  const auto cleared = seen.rfind("\r\033[K");
  const auto table = seen.find("stopped by");
  EXPECT_NE(bar, std::string::npos) << seen;
  EXPECT_LT(bar, table) << seen;
  EXPECT_LT(cleared, table) << seen;
}

}  // namespace
}  // namespace strak::test
