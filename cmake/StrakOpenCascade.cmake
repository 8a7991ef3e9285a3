# strak_cad: the *_occ.cpp files of strak/exchange, the only ones that see Open CASCADE. A library of its own, so that a
# program that needs no CAD files links none of it.
#
# All of these components must be named or the package refuses ("imported targets missing"); asking for a version fails
# too, because its version file wants exactly its own.
find_package(OpenCASCADE REQUIRED COMPONENTS
  FoundationClasses ModelingData ModelingAlgorithms Visualization ApplicationFramework DataExchange)
file(GLOB cadSources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/strak/exchange/*_occ.cpp)
if(cadSources)
  add_library(strak_cad STATIC ${cadSources})
  target_include_directories(strak_cad SYSTEM PRIVATE ${OpenCASCADE_INCLUDE_DIR})
  target_compile_definitions(strak_cad PUBLIC STRAK_HAS_CAD)
  target_link_libraries(strak_cad PRIVATE $<BUILD_INTERFACE:strak_flags>)
  target_link_libraries(strak_cad PUBLIC strak_exchange
    PRIVATE TKXDESTEP TKXDEIGES TKSTEP TKSTEPBase TKIGES TKXSBase TKXCAF TKLCAF TKCAF TKCDF TKShHealing TKTopAlgo TKMesh TKBO TKPrim TKGeomAlgo TKGeomBase TKBRep TKG3d TKG2d TKMath TKernel)
  add_library(strak::cad ALIAS strak_cad)
  set_target_properties(strak_cad PROPERTIES EXPORT_NAME cad)
  set_property(GLOBAL APPEND PROPERTY STRAK_ROOMS strak_cad)
endif()
