# SPDX-License-Identifier: BSD-3-Clause
# How every target of the project is compiled; link `cliquevo_options` to get it.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

find_program(CLIQUEVO_CCACHE ccache)
if(CLIQUEVO_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CLIQUEVO_CCACHE})
endif()

# Several sources compiled as one: headers are read once for all of them, which takes about a third off a first build. Not for
# who works on the sources: a change compiles its neighbours again.
option(CLIQUEVO_UNITY "Compile a library's sources together" OFF)
set(CMAKE_UNITY_BUILD ${CLIQUEVO_UNITY})
set(CMAKE_UNITY_BUILD_BATCH_SIZE 8)
# Sources that cannot be: a macro of a system header has the name of another source's constant; g++ takes the Impl of a
# class for a header's, and warns of its members; or a program may link the library without them, or with others instead.
function(cliquevo_compile_alone)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

set(CLIQUEVO_SANITIZE "" CACHE STRING "Sanitizers to build with, e.g. address,undefined or thread")

add_library(cliquevo_options INTERFACE)
target_include_directories(cliquevo_options INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}>)
target_compile_features(cliquevo_options INTERFACE cxx_std_20)
# A fused multiply-add (-ffp-contract) rounds once where two operations round twice: results would depend on the machine.
foreach(flag -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual
    -Werror -ffp-contract=off)
  target_compile_options(cliquevo_options INTERFACE $<BUILD_INTERFACE:${flag}>)  # ours, not those of who links us
endforeach()
if(CLIQUEVO_SANITIZE)
  # A target whose property CLIQUEVO_UNSANITIZED is on is compiled without.
  target_compile_options(cliquevo_options INTERFACE
    $<$<NOT:$<BOOL:$<TARGET_PROPERTY:CLIQUEVO_UNSANITIZED>>>:-fsanitize=${CLIQUEVO_SANITIZE}>
    -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(cliquevo_options INTERFACE -fsanitize=${CLIQUEVO_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # The sanitizers' own code misleads these two; the plain builds have them on.
    target_compile_options(cliquevo_options INTERFACE -Wno-maybe-uninitialized -Wno-stringop-overflow)
  endif()
endif()
