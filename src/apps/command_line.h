// Options of our programs: one table makes both the parser and the help text.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace gprodom {

// Bad usage: exit code 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct Option {
  std::string name;      // "--set"; with a short form, "-c, --config"
  std::string argument;  // "KEY=VALUE"; empty if it takes none
  std::string help;
  std::function<void(const std::string&)> apply;  // gets the argument
};

// -c and --set, the same in every program that takes a config. Their arguments are appended to the
// lists.
Option config_option(std::vector<std::string>& paths);
Option set_option(std::vector<std::string>& overrides);

class CommandLine {
 public:
  // The help text begins with `usage` and `purpose`. --help and --version are added to the options.
  CommandLine(std::string program, std::string usage, std::string purpose,
              std::vector<Option> options);

  // Calls `apply` of each option in order and returns the other arguments. Throws UsageError.
  std::vector<std::string> parse(int argc, char** argv) const;

  // Prints the help or the version if --help or --version is given, and returns whether it was.
  bool answer(int argc, char** argv) const;

  // Runs `work` and turns an exception into one line and an exit code: 1 failed, 2 bad usage. It is
  // also a failure if stdout could not be written.
  int run(const std::function<int()>& work) const;

 private:
  const Option* find(const std::string& name) const;
  void print_help() const;

  std::string program_, usage_, purpose_;
  std::vector<Option> options_;
};

}  // namespace gprodom
