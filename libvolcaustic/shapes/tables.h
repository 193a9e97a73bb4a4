// What all programs that were cut out of one share.
#pragma once

#include "core/hash.h"
#include "shapes/function.h"
#include "shapes/program.h"
#include "shapes/quadric.h"

#include <memory>
#include <string>
#include <vector>

namespace volcaustic {

struct ShapeProgram::Tables {
  struct Function {
    std::unique_ptr<ShapeFunction> evaluate;
    std::uint64_t hash; ///< of what decides its values
  };
  std::vector<Function> functions;
  std::vector<PlacedQuadric> quadrics;
  std::vector<std::string> partNames{""};
};

} // namespace volcaustic
