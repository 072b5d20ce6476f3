#include "kalfem/base/located.hpp"

namespace kalfem {



}  // namespace kalfem
