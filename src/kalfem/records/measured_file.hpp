// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Dense>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace kalfem {

/// Where a sensor sits and which way it looks, as far as its file says it.
struct MeasuredPlace {
  std::optional<long> node = {};
  int direction = 0;  ///< 1, 2, 3: along x, y, z; 4, 5, 6: about them; with a minus sign against them; 0: not known
};

/// One series of samples of a file, in the file's units.
struct MeasuredChannel {
  std::string name;
  std::string unit = {};      ///< as parse_unit() reads it, or as the file has it; empty: not stated
  std::string quantity = {};  ///< "acceleration", "force", ...; empty: not stated
  std::string description = {};
  MeasuredPlace place = {};
  double start = 0.0;          ///< time of the first sample [s]
  double interval = 0.0;       ///< between samples [s]; 0: not known, or the times are given
  Eigen::VectorXd times = {};  ///< of each sample [s], where they are uneven; empty: even
  Eigen::VectorXd values = {};
  std::vector<std::string> other_names = {};  ///< by which it can be asked for too
};

/// What a complex function of frequency is.
enum class MeasuredFunctionKind { frequency_response, coherence, auto_spectrum, cross_spectrum, other };

/// A function of frequency of a file, in the file's units.
struct MeasuredFunction {
  std::string name;
  std::string unit = {};
  std::string description = {};
  MeasuredFunctionKind kind = MeasuredFunctionKind::other;
  MeasuredPlace response = {};
  MeasuredPlace reference = {};
  Eigen::VectorXd lines = {};  ///< [Hz]
  Eigen::VectorXcd values = {};
  std::vector<std::string> other_names = {};  ///< by which it can be asked for too
};

/// A measured mode, or a static shape, at nodes.
struct MeasuredShape {
  std::string name;
  double frequency = 0.0;        ///< [Hz]
  double damping = 0.0;          ///< ratio to critical
  std::vector<long> nodes = {};  ///< one a row
  Eigen::MatrixXcd values = {};  ///< nodes x 3 or 6
};

/// A point of the test's geometry [m], or in the file's unit of length where it states none.
struct MeasuredNode {
  long number = 0;
  std::array<double, 3> position = {};
};

/// Which points of the test's geometry an element or a line of a picture joins, in order.
struct MeasuredLine {
  long number = 0;
  std::string name = {};
  int kind = 0;  ///< of an element, by the numbers of its format; 0: a line to draw
  std::vector<long> nodes = {};
};

/// Everything that a file of a test bench holds, whatever its format, before anything is chosen or converted.
struct MeasuredFile {
  std::string format;  ///< "Universal file", "TDMS", ...
  std::vector<MeasuredChannel> channels = {};
  std::vector<MeasuredFunction> functions = {};
  std::vector<MeasuredShape> shapes = {};
  std::vector<MeasuredNode> nodes = {};
  std::vector<MeasuredLine> lines = {};
  std::string description = {};
  std::vector<std::string> skipped = {};  ///< parts that are not read: what and where, a sentence each
  std::vector<std::string> notes = {};    ///< contradictions of the file, and how it was taken, a sentence each
};

}  // namespace kalfem
