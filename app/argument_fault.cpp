#include "app/argument_fault.h"

#include <algorithm>
#include <cctype>
#include <vector>

#include <fmt/format.h>

#include "config/spelling.h"
#include "config/yaml_limits.h"

namespace headway::app {

namespace {

using Texts = std::vector<std::string>;

Texts options_of(const CLI::App& command) {
  Texts names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string did_you_mean(const std::string& word, const Texts& known) {
  const std::string meant = config::meant_by(word, known);
  return meant.empty() ? "" : fmt::format("; did you mean {}?", meant);
}

/// Of an argument that looks like an option; empty: it does not.
std::string option_in(const std::string& argument) {
  const std::string name = argument.substr(0, argument.find('='));
  if (name.size() > 2 && name.starts_with("--")) return name;
  // -goal; but -1,0 is a number.
  const bool is_word = name.size() > 2 && name[0] == '-' && std::isalpha(static_cast<unsigned char>(name[1]));
  return is_word ? "-" + name : "";
}

/// The first argument that nobody takes: an option before others, for what is missing or too much is mostly
/// what that was to be. Empty: there is none.
std::string stranger(const CLI::App& program, const CLI::App& command) {
  Texts rest = program.remaining(true);
  const Texts known = options_of(command);
  for (const std::string& argument : rest) {
    const std::string name = option_in(argument);
    if (name.empty()) continue;
    std::string meant = did_you_mean(name, known);
    if (meant.empty() && std::find(known.begin(), known.end(), name) != known.end())
      meant = fmt::format("; did you mean {}?", name);
    if (meant.empty()) meant = fmt::format(", expected one of: {}", fmt::join(known, ", "));
    return fmt::format("{} is no option{}", config::one_line(argument.substr(0, argument.find('='))), meant);
  }
  rest.erase(std::remove(rest.begin(), rest.end(), "--"), rest.end());
  if (rest.empty()) return "";
  return fmt::format("'{}' is too much, expected no more than options: {}", config::one_line(rest.back()),
                     fmt::join(known, ", "));
}

/// The option or argument that a message of CLI11 begins with.
const CLI::Option* option_named_in(const CLI::App& command, const std::string& message) {
  const std::string name = message.substr(0, message.find_first_of(": "));
  for (const CLI::Option* option : command.get_options())
    if (option->get_name() == name) return option;
  return nullptr;
}

std::string wrong_count(const CLI::Option& option, const std::string& message) {
  const bool none = message.find("missing") != std::string::npos;
  const bool many = message.find("At Most") != std::string::npos;
  const std::string form =
      option.get_option_text().empty() ? option.get_type_name() : option.get_option_text();
  return fmt::format("{}: {}, expected {} ({})", option.get_name(),
                     none   ? "a value is missing"
                     : many ? "too many values"
                            : "too few values",
                     form, option.get_description());
}

std::string in_words(const CLI::App& command, const CLI::ParseError& fault) {
  const std::string message = config::one_line(fault.what());
  const CLI::Option* option = option_named_in(command, message);
  if (!option) return message;
  if (fault.get_name() == "RequiredError") return fmt::format("{}: {}", message, option->get_description());
  if (fault.get_name() == "ArgumentMismatch") return wrong_count(*option, message);
  return message;
}

std::string no_command(const CLI::App& program, const CLI::App& parent, const std::string& chosen) {
  Texts commands;
  for (const CLI::App* command : parent.get_subcommands([](const CLI::App*) { return true; }))
    commands.push_back(command->get_name());
  const Texts rest = program.remaining(true);
  const std::string word = rest.empty() ? "" : rest.front();
  const std::string meant = did_you_mean(word, commands);
  return fmt::format("{}{}{}; see 'headway {}--help'", chosen.empty() ? "" : chosen + ": ",
                     word.empty() ? "no command" : fmt::format("'{}' is no command", config::one_line(word)),
                     meant.empty() ? fmt::format(", expected one of: {}", fmt::join(commands, ", ")) : meant,
                     chosen.empty() ? "" : chosen + " ");
}

}  // namespace

std::string argument_fault(const CLI::App& program, const CLI::ParseError& fault) {
  std::string chosen;
  const CLI::App* last = &program;
  while (!last->get_subcommands().empty()) {
    last = last->get_subcommands().front();
    chosen += (chosen.empty() ? "" : " ") + last->get_name();
  }
  if (last->get_require_subcommand_min() > 0) return no_command(program, *last, chosen);
  const std::string unexpected = stranger(program, *last);
  return fmt::format("{0}: {1}; see 'headway {0} --help'", chosen,
                     unexpected.empty() ? in_words(*last, fault) : unexpected);
}

}  // namespace headway::app
