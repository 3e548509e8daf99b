// Prints the report of Khronos' validator on the file that is named; node finds the validator by NODE_PATH.
const validator = require("gltf-validator");
const fs = require("fs");

validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2]))).then((report) => console.log(JSON.stringify(report)));
