#include "kalfem/reduction/superelement.hpp"
