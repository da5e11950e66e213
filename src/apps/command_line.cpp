#include "apps/command_line.h"

#include <cstdio>
#include <utility>

#include "gprodom/version.h"

namespace gprodom {
namespace {

// "-c, --config" answers to both.
bool answers_to(const Option& option, const std::string& name) {
  const auto comma = option.name.find(", ");
  if (comma == std::string::npos) return option.name == name;
  return option.name.substr(0, comma) == name || option.name.substr(comma + 2) == name;
}

Option added_to(std::vector<std::string>& list, std::string name, std::string argument,
                std::string help) {
  return {std::move(name), std::move(argument), std::move(help),
          [&list](const std::string& text) { list.push_back(text); }};
}

}  // namespace

Option config_option(std::vector<std::string>& paths) {
  return added_to(paths, "-c, --config", "CONFIG",
                  "YAML file of keys that differ from the defaults; a later one overrides "
                  "earlier ones");
}

Option set_option(std::vector<std::string>& overrides) {
  return added_to(overrides, "--set", "KEY=VALUE",
                  "override one key, such as wheel.scale=0.97; may be repeated");
}

CommandLine::CommandLine(std::string program, std::string usage, std::string purpose,
                         std::vector<Option> options)
    : program_(std::move(program)),
      usage_(std::move(usage)),
      purpose_(std::move(purpose)),
      options_(std::move(options)) {
  options_.push_back({"--version", "", "print the version and end", {}});
  options_.push_back({"-h, --help", "", "print this and end", {}});
}

const Option* CommandLine::find(const std::string& name) const {
  for (const auto& option : options_) {
    if (answers_to(option, name)) return &option;
  }
  return nullptr;
}

std::vector<std::string> CommandLine::parse(int argc, char** argv) const {
  std::vector<std::string> others;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument.size() < 2 || argument[0] != '-') {
      others.push_back(argument);
      continue;
    }
    const auto equals = argument.rfind("--", 0) == 0 ? argument.find('=') : std::string::npos;
    const std::string name = argument.substr(0, equals);
    const Option* option = find(name);
    if (!option) throw UsageError("unknown option " + name);
    std::string value;
    if (equals != std::string::npos) {
      if (option->argument.empty()) throw UsageError(name + " takes no value");
      value = argument.substr(equals + 1);
    } else if (!option->argument.empty()) {
      if (++i >= argc) throw UsageError(name + " needs " + option->argument);
      value = argv[i];
    }
    if (option->apply) option->apply(value);
  }
  return others;
}

bool CommandLine::answer(int argc, char** argv) const {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "-h" || argument == "--help") {
      print_help();
      return true;
    }
    if (argument == "--version") {
      std::printf("%s %s\n", program_.c_str(), kVersion);
      return true;
    }
  }
  return false;
}

void CommandLine::print_help() const {
  std::printf("usage: %s %s\n\n%s\n\noptions:\n", program_.c_str(), usage_.c_str(),
              purpose_.c_str());
  for (const auto& option : options_) {
    const std::string name = option.name + (option.argument.empty() ? "" : " " + option.argument);
    std::printf("  %-24s %s\n", name.c_str(), option.help.c_str());
  }
}

int CommandLine::run(const std::function<int()>& work) const {
  try {
    const int code = work();
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw std::runtime_error("standard output: cannot be written");
    return code;
  } catch (const UsageError& error) {
    std::fprintf(stderr, "%s: %s\nusage: %s %s\n", program_.c_str(), error.what(), program_.c_str(),
                 usage_.c_str());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program_.c_str(), error.what());
    return 1;
  }
}

}  // namespace gprodom
