#include "tool/command/options.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <sstream>
#include <variant>

#include <nlohmann/json.hpp>

#include "tool/atomic_file.h"
#include "tool/error.h"
#include "tool/printable.h"

namespace nlg {
namespace {

constexpr size_t kMaxYamlBytes = size_t{1} << 20;
constexpr size_t kMaxQuotedBytes = 60;

struct IntTarget {
  int* value;
  int min, max;
};
struct DoubleTarget {
  double* value;
  double min, max;
};
struct NumbersTarget {
  std::vector<double>* values;
  double min, max;
};
using TextList = std::vector<std::string>;
struct ChoiceTarget {
  std::string* value;
  TextList one_of;
};
using Target = std::variant<IntTarget, uint64_t*, DoubleTarget, NumbersTarget, bool*, std::string*, ChoiceTarget, TextList*>;

struct Option {
  std::string name;
  std::string help;
  Target target;
  std::string group;
  std::string passed_from;  // a section of which only the workflow reads it; empty: the table's own
  bool is_flag_alone = false;
  bool is_repeated = false;  // of a list: whether its flag is given once for each text
  CLI::Option* flag = nullptr;

  bool isOfSection() const { return passed_from.empty() && !is_flag_alone; }
};

// What the user wrote, fit for a one-line message.
std::string quoted(const std::string& text) {
  std::string shown = "'";
  for (const char c : text.substr(0, kMaxQuotedBytes)) {
    const auto byte = static_cast<unsigned char>(c);
    shown += byte < 0x20 || byte == 0x7f ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
  }
  return shown + (text.size() > kMaxQuotedBytes ? "'…" : "'");
}

// The whole of text as a decimal number; from_chars knows no locale, no blanks and no sign of plus.
template <class T>
std::optional<T> parseNumber(const std::string& text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

// Each target says what it expects, takes a text (false: not what it expects), and shows itself.
std::string expected(const IntTarget& target) {
  constexpr int kLowest = std::numeric_limits<int>::min(), kHighest = std::numeric_limits<int>::max();
  if (target.min == kLowest && target.max == kHighest) return "an integer";
  if (target.max == kHighest) return fmt::format("an integer of at least {}", target.min);
  if (target.min == kLowest) return fmt::format("an integer of at most {}", target.max);
  return fmt::format("an integer in [{}, {}]", target.min, target.max);
}
std::string expected(uint64_t*) { return "an unsigned 64-bit integer"; }
std::string expected(const DoubleTarget& target) {
  constexpr double kHighest = std::numeric_limits<double>::max();
  if (target.min == -kHighest && target.max == kHighest) return "a finite number";
  if (target.max == kHighest) return fmt::format("a finite number of at least {}", target.min);
  if (target.min == -kHighest) return fmt::format("a finite number of at most {}", target.max);
  return fmt::format("a finite number in [{}, {}]", target.min, target.max);
}
std::string expected(const NumbersTarget& target) { return fmt::format("finite numbers in [{}, {}]", target.min, target.max); }
std::string expected(bool*) { return "true or false"; }
std::string expected(std::string*) { return "a text"; }
std::string expected(const ChoiceTarget& target) {
  const auto last = target.one_of.end() - 1;
  return fmt::format("{} or {}", fmt::join(target.one_of.begin(), last, ", "), *last);
}
std::string expected(TextList*) { return "a list of texts, none empty"; }

bool take(const IntTarget& target, const std::string& text) {
  const auto number = parseNumber<int>(text);
  if (!number || *number < target.min || *number > target.max) return false;
  *target.value = *number;
  return true;
}
bool take(uint64_t* value, const std::string& text) {
  const auto number = parseNumber<uint64_t>(text);
  if (number) *value = *number;
  return number.has_value();
}
bool take(const DoubleTarget& target, const std::string& text) {
  const auto number = parseNumber<double>(text);
  if (!number || !std::isfinite(*number) || *number < target.min || *number > target.max) return false;
  *target.value = *number;
  return true;
}
bool take(const NumbersTarget& target, const std::string& text) {
  double number = 0.0;
  if (!take(DoubleTarget{&number, target.min, target.max}, text)) return false;
  target.values->push_back(number);
  return true;
}
bool take(bool* value, const std::string& text) {
  if (text != "true" && text != "false") return false;
  *value = text == "true";
  return true;
}
bool take(std::string* value, const std::string& text) {
  // most texts become paths, which the system would cut at the NUL
  if (text.find('\0') != std::string::npos) return false;
  *value = text;
  return true;
}
bool take(const ChoiceTarget& target, const std::string& text) {
  if (std::find(target.one_of.begin(), target.one_of.end(), text) == target.one_of.end()) return false;
  *target.value = text;
  return true;
}
bool take(TextList* list, const std::string& text) {
  std::string item;
  if (text.empty() || !take(&item, text)) return false;
  list->push_back(item);
  return true;
}

nlohmann::ordered_json shown(const IntTarget& target) { return *target.value; }
nlohmann::ordered_json shown(const DoubleTarget& target) { return *target.value; }
nlohmann::ordered_json shown(const NumbersTarget& target) { return *target.values; }
nlohmann::ordered_json shown(const ChoiceTarget& target) { return *target.value; }
template <class T>
nlohmann::ordered_json shown(T* value) {
  return *value;
}

// The one conversion of text, for YAML and flags alike.
void takeOrThrow(const Option& option, const std::string& place, const std::string& text) {
  const bool taken = std::visit([&](const auto& target) { return take(target, text); }, option.target);
  if (taken) return;
  throw UsageError(place, std::visit([](const auto& target) { return expected(target); }, option.target), quoted(text));
}

// All that there is to know of it but its section.
nlohmann::ordered_json describeOption(const Option& option) {
  nlohmann::ordered_json json = {{"name", option.name},
                                 {"default", std::visit([](const auto& target) { return shown(target); }, option.target)}};
  const auto addRange = [&](const auto& target) {
    using Limits = std::numeric_limits<std::decay_t<decltype(target.min)>>;
    if (target.min != Limits::lowest()) json["min"] = target.min;
    if (target.max != Limits::max()) json["max"] = target.max;
  };
  if (const auto* target = std::get_if<IntTarget>(&option.target)) addRange(*target);
  if (const auto* target = std::get_if<DoubleTarget>(&option.target)) addRange(*target);
  if (std::holds_alternative<uint64_t*>(option.target)) json["min"] = 0;
  if (const auto* target = std::get_if<ChoiceTarget>(&option.target)) json["one_of"] = target->one_of;
  json["group"] = option.group;
  json["help"] = option.help;
  return json;
}

// " (1 to 64; default 2)", of what there is of it.
std::string limitsAndDefault(const nlohmann::ordered_json& option) {
  const nlohmann::ordered_json& value = option["default"];
  if (value == "" || value == nlohmann::ordered_json::array()) return "";
  if (value.is_array()) {
    TextList items;  // texts, or numbers
    for (const nlohmann::ordered_json& item : value) items.push_back(item.is_string() ? item.get<std::string>() : item.dump());
    return fmt::format(" (default {})", fmt::join(items, ","));
  }
  if (value.is_string()) return fmt::format(" (default {})", value.get<std::string>());
  if (value.is_boolean()) return fmt::format(" (default {})", value.get<bool>());
  std::string limits;
  if (option.contains("min")) limits = fmt::format("at least {}; ", option["min"].get<double>());
  if (option.contains("max")) limits = fmt::format("at most {}; ", option["max"].get<double>());
  if (option.contains("min") && option.contains("max"))
    limits = fmt::format("{} to {}; ", option["min"].get<double>(), option["max"].get<double>());
  return fmt::format(" ({}default {})", limits, value.get<double>());
}

std::string flagOf(const std::string& name) {
  std::string flag = "--" + name;
  std::replace(flag.begin(), flag.end(), '_', '-');
  return flag;
}

[[noreturn]] void throwUnknownKey(const std::string& place, const std::string& key, const std::vector<std::string>& known) {
  std::string got = quoted(key);
  if (const auto nearest = nearestName(key.substr(0, 2 * kMaxQuotedBytes), known))
    got += fmt::format(" (did you mean '{}'?)", *nearest);
  throw UsageError(place, fmt::format("one of [{}]", fmt::join(known, ", ")), got);
}

// Sees where the contents of documents begin, and nothing else.
class DocumentStarts : public YAML::EventHandler {
 public:
  std::vector<YAML::Mark> marks;

  void OnDocumentStart(const YAML::Mark&) override { is_expected_ = true; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { take(mark); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { take(mark); }
  void OnScalar(const YAML::Mark& mark, const std::string&, YAML::anchor_t, const std::string&) override { take(mark); }
  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override {
    take(mark);
  }
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t, YAML::EmitterStyle::value) override { take(mark); }
  void OnMapEnd() override {}

 private:
  void take(const YAML::Mark& mark) {
    if (std::exchange(is_expected_, false)) marks.push_back(mark);
  }

  bool is_expected_ = false;
};

// Of more than two documents the first two. yaml-cpp's own list of all has no end on some texts that are no YAML: ", # o" gives it one
// empty document after the other.
std::vector<YAML::Mark> documentStarts(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentStarts starts;
  while (starts.marks.size() < 2 && parser.HandleNextDocument(starts)) {
  }
  return std::move(starts.marks);
}

// A YAML file with the name under which the user knows it.
class YamlFile {
 public:
  explicit YamlFile(const std::string& path) : path_(path) {
    const std::string text = readFile(path, kMaxYamlBytes);
    try {
      const std::vector<YAML::Mark> starts = documentStarts(text);
      if (starts.size() > 1) throw UsageError(place(starts[1]), "one YAML document", "a second one");
      if (!starts.empty()) root_ = YAML::Load(text);
    } catch (const YAML::Exception& error) {
      throw UsageError(place(error.mark), "readable YAML", error.msg);
    }
  }
  const YAML::Node& root() const { return root_; }

  std::string place(const YAML::Mark& mark) const {
    return mark.is_null() ? path_ : fmt::format("{}:{}:{}", path_, mark.line + 1, mark.column + 1);
  }
  std::string place(const YAML::Node& node) const { return place(node.Mark()); }

  // The text of a scalar. Tags would promise a meaning that no option has (!!binary), and nothing is not a value.
  std::string scalar(const YAML::Node& node, const std::string& at, const std::string& expectation) const {
    if (!node.IsScalar()) throw UsageError(at, expectation, kindOf(node));
    if (node.Tag() != "?" && node.Tag() != "!" && !node.Tag().empty()) {
      throw UsageError(at, expectation + " without a tag", quoted(node.Tag()));
    }
    return node.Scalar();
  }

  // Calls visit(key, value, place of the key) for every entry of a map, whose keys must be distinct scalars; nothing is an empty
  // map.
  template <class Visit>
  void forEachEntry(const YAML::Node& map, const Visit& visit) const {
    if (!map.IsDefined() || map.IsNull()) return;
    if (!map.IsMap()) throw UsageError(place(map), "a map of keys and values", kindOf(map));
    std::set<std::string> seen;
    for (const auto& entry : map) {
      const std::string key = scalar(entry.first, place(entry.first), "a key");
      if (!seen.insert(key).second) throw UsageError(place(entry.first), "each key once", quoted(key) + " again");
      visit(key, entry.second, place(entry.first));
    }
  }

  static std::string kindOf(const YAML::Node& node) {
    if (node.IsScalar()) return quoted(node.Scalar());
    if (node.IsSequence()) return "a sequence";
    return node.IsMap() ? "a map" : "nothing";
  }

 private:
  std::string path_;
  YAML::Node root_;
};

void takeYaml(const Option& option, const YamlFile& file, const YAML::Node& value, const std::string& key_place) {
  const auto placeOf = [&](const YAML::Node& node) {
    return (node.IsNull() ? key_place : file.place(node)) + ": " + option.name;
  };
  const std::string expectation = std::visit([](const auto& target) { return expected(target); }, option.target);
  if (const auto* list = std::get_if<TextList*>(&option.target)) {
    if (!value.IsSequence()) throw UsageError(placeOf(value), expectation, YamlFile::kindOf(value));
    (*list)->clear();
    for (const auto& item : value) takeOrThrow(option, placeOf(item), file.scalar(item, placeOf(item), expectation));
    return;
  }
  takeOrThrow(option, placeOf(value), file.scalar(value, placeOf(value), expectation));
}

// Items of a list on the command line; an empty text is an empty list.
void takeFlag(const Option& option, const std::string& place, const std::string& text) {
  const auto* list = std::get_if<TextList*>(&option.target);
  if (list == nullptr) return takeOrThrow(option, place, text);
  (*list)->clear();
  for (size_t begin = 0; begin <= text.size() && !text.empty();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    takeOrThrow(option, place, text.substr(begin, end - begin));
    begin = end + 1;
  }
}

}  // namespace

struct OptionTable::Impl {
  std::string section;
  std::vector<Option> options;
  std::string present_group = "Options", present_source;
  bool is_flag_alone = false;  // of what is added
  std::vector<std::string> common;
  std::vector<std::string> notes;

  void add(const std::string& name, Target target, const std::string& help) {
    const bool repeated = std::any_of(options.begin(), options.end(), [&](const Option& o) { return o.name == name; });
    NLG_CHECK(repeated, ==, false);
    options.push_back({name, help, std::move(target), present_group, present_source, is_flag_alone});
  }
};

OptionTable::OptionTable(std::string section) : impl_(std::make_unique<Impl>()) { impl_->section = std::move(section); }
OptionTable::~OptionTable() = default;
OptionTable::OptionTable(OptionTable&&) noexcept = default;
OptionTable& OptionTable::operator=(OptionTable&&) noexcept = default;

void OptionTable::add(const std::string& name, int* value, const std::string& help, int min, int max) {
  NLG_CHECK(*value, >=, min);
  NLG_CHECK(*value, <=, max);
  impl_->add(name, IntTarget{value, min, max}, help);
}
void OptionTable::add(const std::string& name, uint64_t* value, const std::string& help) { impl_->add(name, value, help); }
void OptionTable::add(const std::string& name, double* value, const std::string& help, double min, double max) {
  NLG_CHECK(*value, >=, min);
  NLG_CHECK(*value, <=, max);
  impl_->add(name, DoubleTarget{value, min, max}, help);
}
void OptionTable::add(const std::string& name, std::vector<double>* values, const std::string& help, double min, double max) {
  NLG_CHECK(values->size(), ==, size_t{0});
  impl_->add(name, NumbersTarget{values, min, max}, help);
}
void OptionTable::add(const std::string& name, bool* value, const std::string& help) { impl_->add(name, value, help); }
void OptionTable::add(const std::string& name, std::string* value, const std::string& help) { impl_->add(name, value, help); }
void OptionTable::add(const std::string& name, std::string* value, const std::string& help, std::vector<std::string> one_of) {
  NLG_CHECK(one_of.size(), >=, size_t{2});
  impl_->add(name, ChoiceTarget{value, std::move(one_of)}, help);
}
void OptionTable::add(const std::string& name, std::vector<std::string>* value, const std::string& help) {
  impl_->add(name, value, help);
}

void OptionTable::addRepeated(const std::string& name, std::vector<std::string>* value, const std::string& help) {
  impl_->add(name, value, help);
  impl_->options.back().is_repeated = true;
}

void OptionTable::group(const std::string& name) { impl_->present_group = name; }
void OptionTable::passedFrom(const std::string& section) { impl_->present_source = section; }
void OptionTable::flagsAlone() { impl_->is_flag_alone = true; }

void OptionTable::common(std::vector<std::string> names) { impl_->common = std::move(names); }
const std::vector<std::string>& OptionTable::commonNames() const { return impl_->common; }

void OptionTable::addNote(const std::string& note) { impl_->notes.push_back(note); }
std::string OptionTable::notes() const { return fmt::format("{}", fmt::join(impl_->notes, "\n\n")); }

void OptionTable::addFlags(CLI::App& app) {
  for (Option& option : impl_->options) {
    const std::string help = option.help + limitsAndDefault(describeOption(option));
    // a bool is a switch, "--culling" or "--culling=false"; whatever stands there is kept as text until applyFlags
    const bool is_switch = std::holds_alternative<bool*>(option.target);
    option.flag = is_switch ? app.add_flag(flagOf(option.name), help) : app.add_option(flagOf(option.name), help);
    option.flag->group(option.group);
    if (option.is_repeated) option.flag->expected(1)->take_all();
    if (std::holds_alternative<NumbersTarget>(option.target)) option.flag->expected(-1)->take_all();
  }
}

void OptionTable::readYaml(const std::string& path) {
  const YamlFile file(path);
  const auto takeEntry = [&](const std::string& key, const YAML::Node& value, const std::string& place) {
    const auto& options = impl_->options;
    const auto option =
        std::find_if(options.begin(), options.end(), [&](const Option& o) { return o.name == key && o.isOfSection(); });
    if (option != options.end()) return takeYaml(*option, file, value, place);
    std::vector<std::string> known;
    for (const Option& o : options) {
      if (o.isOfSection()) known.push_back(o.name);
    }
    throwUnknownKey(place, key, known);
  };
  // sections of other tools are known, and passed by
  file.forEachEntry(file.root(), [&](const std::string& key, const YAML::Node& value, const std::string& place) {
    const auto& known = pipelineSections();
    if (std::find(known.begin(), known.end(), key) == known.end()) throwUnknownKey(place, key, known);
    if (key == impl_->section) file.forEachEntry(value, takeEntry);
  });
}

void OptionTable::applyFlags() {
  for (const Option& option : impl_->options) {
    if (option.flag == nullptr || option.flag->count() == 0) continue;
    const std::vector<std::string> given = option.flag->results();
    const auto* numbers = std::get_if<NumbersTarget>(&option.target);
    if (option.is_repeated || numbers != nullptr) {
      if (numbers != nullptr) numbers->values->clear();
      if (option.is_repeated) std::get<TextList*>(option.target)->clear();
      for (const std::string& text : given) takeOrThrow(option, flagOf(option.name), text);
      continue;
    }
    if (given.size() != 1) throw UsageError(flagOf(option.name), "one value", fmt::format("{}", given.size()));
    takeFlag(option, flagOf(option.name), given[0]);
  }
}

nlohmann::ordered_json OptionTable::toJson() const {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Option& option : impl_->options) {
    if (option.isOfSection()) json[option.name] = std::visit([](const auto& target) { return shown(target); }, option.target);
  }
  return json;
}

nlohmann::ordered_json OptionTable::usedJson(const std::vector<std::string>& without) const {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Option& option : impl_->options) {
    if (std::find(without.begin(), without.end(), option.name) == without.end())
      json[option.name] = std::visit([](const auto& target) { return shown(target); }, option.target);
  }
  return json;
}

nlohmann::ordered_json OptionTable::describeAsJson() const {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Option& option : impl_->options) {
    if (option.is_flag_alone) continue;
    nlohmann::ordered_json one = {{"section", option.passed_from.empty() ? impl_->section : option.passed_from}};
    one.update(describeOption(option));
    json.push_back(std::move(one));
  }
  return json;
}

const std::vector<std::string>& pipelineSections() {
  static const std::vector<std::string> sections = {
      "name",     "scenes",   "split",  "representations", "datagen", "basis", "train", "export", "bake",
      "validate", "frontier", "report", "validate_light",  "effort",  "full",  "init",  "data"};
  return sections;
}

}  // namespace nlg
