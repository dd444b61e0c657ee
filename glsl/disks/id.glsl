// Ids lie among floats. As they are they would be denormal numbers, which a device may take for 0; with one bit more they
// are numbers between 2 and 512. `ID_BIT` in disks::sorted.
const uint ID_BIT = 0x40000000u;
float word_of_id(uint id) { return uintBitsToFloat(id | ID_BIT); }
uint id_of_word(float word) { return floatBitsToUint(word) & ~ID_BIT; }
