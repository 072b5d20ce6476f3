#define KALFEM_EIGEN_INSTANCE template
#include "kalfem/base/eigen_instances.hpp"
