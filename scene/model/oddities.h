// Collects the oddities of a file: each kind is told once, with the first part and the number of others.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tool/error.h"

namespace nlg {

// A scene that asks for more than a budget holds (scene_file.h): no part of it that could be left out.
class BudgetError : public InputError {
 public:
  using InputError::InputError;
};

class Oddities {
 public:
  static constexpr const char* kLeftOut = "left out";

  explicit Oddities(std::string path) : start_(std::move(path) + ": ") {}

  void add(const std::string& how, const std::string& part) { parts_[how].push_back(part); }

  // Makes a step of the reading. One that ends in an InputError is odd in the way of `how`, by the error's own words.
  // returns   whether it went well
  // throws    BudgetError, as the step does: no scene may take more by being odd
  template <class Step>
  bool attempt(const std::string& how, const Step& step) {
    try {
      return step(), true;
    } catch (const BudgetError&) {
      throw;
    } catch (const InputError& error) {
      if (!first_ && how.ends_with(kLeftOut)) first_ = error;
      const std::string line = error.what();
      add(how, line.substr(line.starts_with(start_) ? start_.size() : 0));
      return false;
    }
  }

  // Of these errors the first by which something was left out: for a file of which nothing is left.
  const std::optional<InputError>& first() const { return first_; }
  std::vector<std::string> notes() const;

 private:
  const std::string start_;                                // of its errors: the file's name
  std::map<std::string, std::vector<std::string>> parts_;  // by what is said of them
  std::optional<InputError> first_;
};

// "1 lamp", "3 lamps".
std::string counted(size_t count, const std::string& one, const std::string& many);
// "door, wall and 3 more".
std::string listed(const std::vector<std::string>& names);

}  // namespace nlg
