// Command-line arguments as main() receives them.
#pragma once

#include <string>
#include <vector>

namespace poretwin::peer {

class ArgumentList {
 public:
  ArgumentList(std::string program, const std::vector<std::string>& arguments) : words_(arguments) {
    words_.insert(words_.begin(), std::move(program));
    for (auto& word : words_) pointers_.push_back(word.data());
    pointers_.push_back(nullptr);
  }
  [[nodiscard]] int count() const { return static_cast<int>(words_.size()); }
  [[nodiscard]] char** data() { return pointers_.data(); }

 private:
  std::vector<std::string> words_;
  std::vector<char*> pointers_;
};

}  // namespace poretwin::peer
