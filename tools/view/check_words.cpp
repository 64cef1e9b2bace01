// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/check_words.h"

#include <nlohmann/json.hpp>

#include "tools/view/facts.h"

namespace cliquevo::view {

nlohmann::json check_words() {
  using nlohmann::json;
  json names(vo::kChecks, nullptr);
  json texts(vo::kChecks, nullptr);
  for (const vo::CheckRow& row : vo::kCheckRows) {
    const auto number = static_cast<std::size_t>(row.check);
    names[number] = row.name;
    texts[number] = {{"unit", row.unit}, {"meaning", row.meaning}};
  }
  json verdicts = json::array();
  for (int s = 0; s <= static_cast<int>(vo::Status::weak); ++s) {
    verdicts.push_back(vo::status_name(static_cast<vo::Status>(s)));
  }
  return {{"checks", std::move(names)}, {"check_texts", std::move(texts)}, {"verdicts", std::move(verdicts)}};
}

}  // namespace cliquevo::view
