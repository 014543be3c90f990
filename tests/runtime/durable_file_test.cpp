// Processes that save maps are killed at random moments, and what they leave behind is read.
#include "runtime/durable_file.h"

#include <array>
#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "hal/error.h"
#include "nav/cold_map_file.h"
#include "tests/temporary_folder.h"

namespace headway::runtime {
namespace {

namespace fs = std::filesystem;
using Write = std::function<void(const fs::path&, const std::function<void(std::ostream&)>&)>;

/// State n of a map that grows and changes everywhere.
nav::ColdMap state(int n) {
  nav::ColdMap map(0.05);
  nav::BrickValues values;
  for (int b = 0; b < 100 + n % 50; ++b) {
    values.fill(static_cast<nav::LogOdds>(n % 70));
    map.put({b % 10, b / 10, n}, values);
  }
  return map;
}

/// Runs in a process of its own until that is killed.
pid_t start(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child != 0) return child;
  work();
  _exit(0);
}

void expect_killed(pid_t child) {
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
}

/// Saves state after state, and tells of each that is saved.
class Saver {
 public:
  Saver(const fs::path& file, int first) {
    if (pipe(ends_.data()) != 0) throw std::runtime_error("no pipe");
    child_ = start([&] {
      for (int n = first;; ++n) {
        write_durably(file, [n](std::ostream& out) { nav::write_map_file(state(n), out); });
        if (write(ends_[1], &n, sizeof n) != sizeof n) _exit(1);
      }
    });
    close(ends_[1]);
  }
  ~Saver() { close(ends_[0]); }
  Saver(const Saver&) = delete;
  Saver& operator=(const Saver&) = delete;

  /// The next state that it says is saved; 0 when it is dead and has said all.
  int saved() const {
    int n = 0;
    return read(ends_[0], &n, sizeof n) == sizeof n ? n : 0;
  }
  void end() const {
    kill(child_, SIGKILL);
    expect_killed(child_);
  }

 private:
  std::array<int, 2> ends_{};
  pid_t child_ = 0;
};

TEST(DurableFile, LosesNoSavedStateHoweverItsWriterIsKilled) {
  using Clock = std::chrono::steady_clock;
  const TemporaryFolder folder;
  const fs::path file = folder / "walk.hmap";
  std::mt19937_64 random(1);
  int saved = 0, cut_short = 0;
  // When the writer gets its turn is the machine's to say: a busy one needs more rounds to be caught at it.
  for (int round = 0; round < 40 || (cut_short == 0 && round < 1000); ++round) {
    const Saver saver(file, saved + 1);
    saved = saver.saved();
    const auto begin = Clock::now();
    saved = saver.saved();
    const auto one_save = Clock::now() - begin;
    const auto moment = Clock::now() + one_save * static_cast<int>(random() % 1000) / 1000;
    while (Clock::now() < moment) {
    }
    saver.end();
    for (int n = saver.saved(); n != 0; n = saver.saved()) saved = n;
    cut_short += fs::exists(folder / "walk.hmap.part");
    const nav::ColdMap found = nav::read_map_file(file);
    const bool one_more = !(found == state(saved));  // saved, but killed before it said so
    ASSERT_TRUE(found == state(saved + one_more)) << "after state " << saved << " in round " << round;
    saved += one_more;
  }
  EXPECT_GT(cut_short, 0) << "no writer was killed while it wrote";
}

/// Kills a writer in the middle of state 2 and tells whether state 1 is still there, whole.
bool keeps_the_old_state(const Write& writer, std::size_t written_of_1000) {
  const TemporaryFolder folder;
  const fs::path file = folder / "map.hmap";
  writer(file, [](std::ostream& out) { nav::write_map_file(state(1), out); });
  expect_killed(start([&] {
    writer(file, [&](std::ostream& out) {
      std::ostringstream whole;
      nav::write_map_file(state(2), whole);
      out << whole.str().substr(0, whole.str().size() * written_of_1000 / 1000) << std::flush;
      raise(SIGKILL);
    });
  }));
  try {
    return nav::read_map_file(file) == state(1);
  } catch (const InputError&) {
    return false;
  }
}

TEST(DurableFile, KeepsTheOldStateWhereverTheNewOneEndsInTheMiddle) {
  for (std::size_t part = 0; part <= 1000; part += 50)
    EXPECT_TRUE(keeps_the_old_state(write_durably, part)) << part;
}

TEST(DurableFile, IsWhatPlainWritingIsNot) {
  const Write plain = [](const fs::path& file, const std::function<void(std::ostream&)>& write) {
    std::ofstream out(file, std::ios::binary);
    write(out);
  };
  EXPECT_FALSE(keeps_the_old_state(plain, 500));
}

TEST(DurableFile, SaysWhatIsWrongAndKeepsWhatWasThere) {
  const TemporaryFolder folder;
  const auto text = [](std::ostream& out) { out << "new"; };
  const auto message = [&](const fs::path& file) {
    try {
      write_durably(file, text);
    } catch (const InputError& e) {
      return std::string(e.what());
    } catch (const Error& e) {
      return std::string("the machine: ") + e.what();
    }
    return std::string("written");
  };
  EXPECT_THAT(message(folder / "none" / "a"),
              testing::AllOf(testing::HasSubstr(
                                 "none/a: cannot be written (No such file or directory), expected a folder"),
                             testing::Not(testing::StartsWith("the machine"))));
  fs::create_directory(folder / "taken");
  std::ofstream(folder / "taken" / "file") << "in the way";
  EXPECT_THAT(message(folder / "taken"), testing::HasSubstr("taken: cannot be replaced"));
  EXPECT_TRUE(fs::exists(folder / "taken" / "file"));
  EXPECT_THROW(write_durably(folder / "half", [](std::ostream&) { throw InputError("no more"); }),
               InputError);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.path()))
    EXPECT_EQ(entry.path().filename(), "taken") << "nothing half written stays";
  if (fs::exists("/dev/full")) {
    fs::create_symlink("/dev/full", folder / "full.part");
    EXPECT_THAT(message(folder / "full"),
                testing::AllOf(testing::StartsWith("the machine: "),
                               testing::HasSubstr("full: cannot be written completely")));
    EXPECT_FALSE(fs::exists(folder / "full"));
  }
}

}  // namespace
}  // namespace headway::runtime
