// A tool's table of options: documentation, default, range, YAML section and command-line flags in one place.
//
// A stage keeps its options in a plain struct whose member initialisers are the defaults, and describes each member once:
//
//     OptionTable table("datagen");
//     table.add("spacing_min_m", &options.spacing_min_m, "smallest probe spacing, metres", 0.01, 100.0);
//
// From that follow the keys of its section in pipeline.yaml, the flags `--spacing-min-m`, the texts of `--help` and `--help-all`,
// the page docs/reference/settings.md and the JSON that travels with every artefact. Order of precedence: default, pipeline.yaml,
// flag.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace CLI {
class App;
}

namespace nlg {

class OptionTable {
 public:
  // section   this tool's key at the top level of pipeline.yaml
  explicit OptionTable(std::string section);
  ~OptionTable();
  OptionTable(OptionTable&&) noexcept;
  OptionTable& operator=(OptionTable&&) noexcept;

  // Describes one option. The pointer must stay valid for the life of the table; its present value is the default.
  // name is snake_case, as in pipeline.yaml; the flag is the same with dashes. Numbers outside [min, max], and any that is
  // not finite, are refused wherever they come from; so are values of another type ("3.5" or "" for an integer).
  void add(const std::string& name, int* value, const std::string& help, int min = std::numeric_limits<int>::min(),
           int max = std::numeric_limits<int>::max());
  void add(const std::string& name, uint64_t* value, const std::string& help);
  void add(const std::string& name, double* value, const std::string& help, double min = -std::numeric_limits<double>::max(),
           double max = std::numeric_limits<double>::max());
  void add(const std::string& name, bool* value, const std::string& help);
  void add(const std::string& name, std::string* value, const std::string& help);
  // one_of   the values that are taken
  void add(const std::string& name, std::string* value, const std::string& help, std::vector<std::string> one_of);
  void add(const std::string& name, std::vector<std::string>* value,
           const std::string& help);  // a YAML sequence; the flag takes a comma-separated list
  // A list of numbers, empty by default; the flag takes them one after another. Of flags alone (flagsAlone).
  void add(const std::string& name, std::vector<double>* values, const std::string& help, double min, double max);
  // The same of texts that may hold commas: the flag is given once for each.
  void addRepeated(const std::string& name, std::vector<std::string>* value, const std::string& help);

  // The headline of --help-all and of the page of settings that the options added from here on stand under.
  void group(const std::string& name);

  // The options added from here on are flags alone: the workflow finds them in another section of pipeline.yaml, and passes them on.
  // They are not in toJson().
  void passedFrom(const std::string& section);

  // The options added from here on are flags of one run, which no configuration holds and which are not in toJson().
  void flagsAlone();

  // What --help shows, by snake_case name, of these options and of those that the tool itself has added to its command line;
  // positionals, what is required and --config it shows in any case. Without this call it shows all of them.
  void common(std::vector<std::string> names);
  const std::vector<std::string>& commonNames() const;

  // What --help-all ends with; --help, too, of a tool that shows all of its options there.
  void addNote(const std::string& note);
  std::string notes() const;

  // Adds one flag an option to the command line, each with its help, default and range. Values are only remembered here.
  void addFlags(CLI::App& app);

  // Reads this tool's section of a YAML file. An absent section leaves the defaults.
  // throws   UsageError with line and column on unreadable YAML, a key at the top level that no stage owns, an unknown or
  //          repeated key in the section, a wrong type, or a value out of range; InputError when the file cannot be read
  void readYaml(const std::string& path);

  // Writes the values of the flags that were given over whatever stood there.
  // throws   UsageError naming the flag
  void applyFlags();

  // The resolved options as a JSON object, keys in the order of the table.
  nlohmann::ordered_json toJson() const;
  // The same with all flags, for the provenance of what one run measured.
  // without   names of options that do not change the result
  nlohmann::ordered_json usedJson(const std::vector<std::string>& without) const;

  // What there is to know of each option, a JSON object each: section, name, default, min, max and one_of where there are any, group, help.
  nlohmann::ordered_json describeAsJson() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The keys that may stand at the top level of pipeline.yaml: one a stage, and those that only the workflow reads.
const std::vector<std::string>& pipelineSections();

}  // namespace nlg
