# Our comments as Doxygen's: what stands before a declaration, or behind it on its line. That a class can be moved is not
# described.
1s@^// SPDX.*@/// \\file@
/^ +[A-Za-z]+\([A-Za-z]+&&\) noexcept;$/d
/operator=\([A-Za-z]+&&\) noexcept;$/d
s@ *// NOLINT.*$@@
s@^\}  // namespace.*@}@
s@^( *)// @\1/// @
s@^(.*[^ ].*[;,{}])( +)// @\1\2///< @
